//! Which nodes of the finest tabulation a tree keeps, and the tree that they make.

use bsdfkit::Result;
use bsdfkit::tree::{TensorTree, TreeBuilder};

use super::fine::Node;
use super::measured::Measured;
use super::subtree_cost::Shape;

/// What becomes of the nodes above and from the top level on.
pub(super) struct Marks {
    pub(super) above: Vec<Vec<Shape>>,
    pub(super) below: Vec<Vec<Shape>>,
}

impl Marks {
    /// The tree of the nodes that are kept.
    pub(super) fn tree(&self, of: &Measured<'_>) -> Result<TensorTree> {
        let mut builder = TreeBuilder::new(of.fine.layout.0);
        self.emit(of, 0, 0, 0, &mut builder)?;
        builder.finish()
    }

    fn emit(
        &self,
        of: &Measured<'_>,
        level: u32,
        z: usize,
        s: usize,
        to: &mut TreeBuilder,
    ) -> Result<()> {
        let scattered = 1usize << (2 * level);
        let k = z * scattered + s;
        if level == of.fine.levels.top {
            let nodes = &of.fine.subtrees[k].nodes;
            return emit_node(nodes, &self.below[k], 0, of.fine.layout.0.children(), to);
        }
        let shape = self.above[level as usize][k];
        if shape == Shape::Leaf {
            return to.leaf(of.mean(level, k));
        }
        to.open_branch()?;
        let parts = of.fine.layout.incident_children();
        for c in 0..4 * parts {
            let (cz, cs) = (z * parts + c % parts, 4 * s + c / parts);
            if cz >= of.fine.layout.incident_cells(level + 1) {
                to.leaf(0.0)?;
            } else if shape == Shape::Grid {
                to.leaf(of.mean(level + 1, cz * 4 * scattered + cs))?;
            } else {
                self.emit(of, level + 1, cz, cs, to)?;
            }
        }
        to.close_branch()
    }
}

fn emit_node(
    nodes: &[Node],
    shapes: &[Shape],
    at: usize,
    count: usize,
    to: &mut TreeBuilder,
) -> Result<()> {
    if shapes[at] == Shape::Leaf {
        return to.leaf(nodes[at].value);
    }
    to.open_branch()?;
    for child in nodes[at].first as usize..nodes[at].first as usize + count {
        match shapes[at] {
            Shape::Grid => to.leaf(nodes[child].value)?,
            _ => emit_node(nodes, shapes, child, count, to)?,
        }
    }
    to.close_branch()
}
