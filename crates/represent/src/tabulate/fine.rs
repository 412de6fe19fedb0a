//! The finest tabulation: everything that was sampled, as subtrees that pruning chooses from.

use super::layout::Layout;
use super::mosaic::Mosaic;

/// A node of a subtree: its mean and 2^rank children or none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Mean f in 1/sr over both cells.
    pub(super) value: f32,
    /// Estimate of the mean |f − value|.
    pub(super) spread: f32,
    /// First of the children, in the tree's order; 0 for none. Children may be shared.
    pub(super) first: u32,
}

impl Node {
    pub(super) fn terminal(value: f64, spread: f64) -> Self {
        Self { value: value as f32, spread: spread as f32, first: 0 }
    }
}

/// Everything below one node of the top level; `nodes[0]` is its root.
pub(super) struct Subtree {
    pub(super) nodes: Vec<Node>,
}

/// Levels of the parts of a tabulation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Levels {
    /// Roots of subtrees, one job per incident cell.
    pub(super) top: u32,
    /// Incident cells with four slices each.
    pub(super) group: u32,
    /// Start of each [`Mosaic`]; at least `top`.
    pub(super) start: u32,
}

/// Where a mosaic stands: a cell, or a node above its start level.
#[derive(Clone, Copy)]
enum Cursor {
    Above(usize),
    At(usize),
}

/// Assembles the subtrees of one incident cell of the top level.
pub(super) struct Assembly<'a> {
    pub(super) layout: Layout,
    pub(super) levels: Levels,
    /// Mosaics of the incident cell's groups, Z order.
    pub(super) mosaics: &'a [Mosaic],
    /// Nodes are not split whose spread is below this share of the flux of an incident cell's
    /// group: the sampling's threshold.
    pub(super) threshold: f64,
}

impl Assembly<'_> {
    /// One subtree for each scattered cell of the top level.
    pub(super) fn subtrees(&self) -> Vec<Subtree> {
        (0..1usize << (2 * self.levels.top))
            .map(|z| {
                let mut nodes = vec![Node::terminal(0.0, 0.0)];
                let cursors = vec![self.cursor(z, self.levels.top); self.mosaics.len()];
                nodes[0] = self.node(&mut nodes, self.levels.top, 0, &cursors);
                nodes.shrink_to_fit();
                Subtree { nodes }
            })
            .collect()
    }

    fn cursor(&self, z: usize, level: u32) -> Cursor {
        if level == self.levels.start { Cursor::At(z) } else { Cursor::Above(z) }
    }

    /// `cursor` one level down in scattered child `child`; a cell without children stays.
    fn descend(&self, cursor: Cursor, mosaic: usize, level: u32, child: usize) -> Cursor {
        match cursor {
            Cursor::Above(z) => self.cursor(4 * z + child, level + 1),
            Cursor::At(cell) => match self.mosaics[mosaic].cells[cell].children {
                0 => cursor,
                first => Cursor::At(first as usize + child),
            },
        }
    }

    /// The node of `level` over the groups from `first` on, one cursor each.
    fn node(&self, nodes: &mut Vec<Node>, level: u32, first: usize, cursors: &[Cursor]) -> Node {
        let uniform = cursors.iter().enumerate().all(|(k, &cursor)| match cursor {
            Cursor::Above(_) => false,
            Cursor::At(cell) => self.mosaics[first + k].cells[cell].children == 0,
        });
        let parts = self.layout.incident_children();
        let mut children = [Node::terminal(0.0, 0.0); 16];
        let count = 4 * parts;
        let before = nodes.len();
        if cursors.len() == 1 {
            let Cursor::At(cell) = cursors[0] else {
                unreachable!("mosaics start above the level of groups");
            };
            let mosaic = &self.mosaics[first];
            if uniform {
                return Node::terminal(
                    mosaic.cells[cell].mean(),
                    WITHIN * mosaic.cells[cell].spread(),
                );
            }
            let scattered = mosaic.cells[cell].children as usize;
            for (c, child) in children[..count].iter_mut().enumerate() {
                *child =
                    slice_node(mosaic, scattered + c / parts, self.layout.slices_in(c % parts));
            }
        } else {
            // Where nothing varies over the scattered cell its four children are the same.
            let distinct = if uniform { parts } else { count };
            let share = cursors.len() / parts;
            let mut below = Vec::with_capacity(share);
            for c in 0..distinct {
                let (part, scattered) = (c % parts, c / parts);
                let from = part * share;
                below.clear();
                below.extend(
                    (from..from + share)
                        .map(|k| self.descend(cursors[k], first + k, level, scattered)),
                );
                children[c] = self.node(nodes, level + 1, first + from, &below);
            }
            for c in distinct..count {
                children[c] = children[c % parts];
            }
        }
        let children = &children[..count];
        let n = count as f64;
        let value = children.iter().map(|c| f64::from(c.value)).sum::<f64>() / n;
        let spread = children
            .iter()
            .map(|c| (f64::from(c.value) - value).abs().max(f64::from(c.spread)))
            .sum::<f64>()
            / n;
        let flux = cursors.len() as f64
            / (first..first + cursors.len())
                .map(|k| 1.0 / self.mosaics[k].hemispherical.max(f64::MIN_POSITIVE))
                .sum::<f64>();
        let area = std::f64::consts::PI / f64::from(1u32 << (2 * level)) * cursors.len() as f64;
        if area * spread <= self.threshold * flux {
            nodes.truncate(before);
            return Node::terminal(value, spread);
        }
        let at = nodes.len() as u32;
        nodes.extend_from_slice(children);
        Node { value: value as f32, spread: spread as f32, first: at }
    }
}

/// Mean |f − mean| of a cell over that of its four samples, where f is linear in the difference of
/// scattered and incident coordinates: ⅓ of the slope times the width over ¼ for samples in the
/// quadrants; half of it for a cell of half the width. Without it, stated errors are a fifth too low.
const WITHIN: f64 = 4.0 / 3.0;

/// The deepest node: `slices` of a mosaic within scattered cell `cell`.
fn slice_node(mosaic: &Mosaic, cell: usize, slices: &[usize]) -> Node {
    let (mut sum, mut weight) = (0.0, 0.0);
    visit(mosaic, cell, 1.0, &mut |samples, w| {
        for &s in slices {
            sum += w * f64::from(samples[s]);
            weight += w;
        }
    });
    let mean = sum / weight;
    let mut spread = 0.0;
    visit(mosaic, cell, 1.0, &mut |samples, w| {
        for &s in slices {
            spread += w * (f64::from(samples[s]) - mean).abs();
        }
    });
    Node::terminal(mean, (spread / weight).max(0.5 * WITHIN * mosaic.cells[cell].spread()))
}

fn visit(mosaic: &Mosaic, cell: usize, weight: f64, f: &mut impl FnMut(&[f32; 4], f64)) {
    let at = &mosaic.cells[cell];
    if at.children == 0 {
        f(&at.samples, weight);
    } else {
        for child in 0..4 {
            visit(mosaic, at.children as usize + child, 0.25 * weight, f);
        }
    }
}

/// The finest tabulation of a whole BSDF.
pub(super) struct Fine {
    pub(super) layout: Layout,
    pub(super) levels: Levels,
    /// By incident cell of the top level, then scattered cell; Z order.
    pub(super) subtrees: Vec<Subtree>,
}

impl Fine {
    /// 1 for every incident cell of the level below groups.
    pub(super) fn alike(&self) -> Vec<f64> {
        vec![1.0; self.layout.incident_cells(self.levels.group + 1)]
    }

    /// ∫ f cos θo dωo of each incident cell at the level of groups, Z order.
    pub(super) fn hemispherical(&self) -> Vec<f64> {
        let parts = self.layout.incident_children();
        let mut sums = vec![0.0; self.layout.incident_cells(self.levels.group)];
        let scattered = 1usize << (2 * self.levels.top);
        for (k, subtree) in self.subtrees.iter().enumerate() {
            let mut stack = vec![(subtree.nodes[0], self.levels.top, k / scattered)];
            while let Some((node, level, z)) = stack.pop() {
                if node.first != 0 {
                    let children = &subtree.nodes[node.first as usize..][..4 * parts];
                    stack.extend(
                        children
                            .iter()
                            .enumerate()
                            .map(|(c, &n)| (n, level + 1, z * parts + c % parts)),
                    );
                    continue;
                }
                let flux =
                    f64::from(node.value) * std::f64::consts::PI / f64::from(1u32 << (2 * level));
                if level > self.levels.group {
                    sums[z / parts] += flux / parts as f64;
                } else {
                    let groups = parts.pow(self.levels.group - level);
                    sums[z * groups..][..groups].iter_mut().for_each(|sum| *sum += flux);
                }
            }
        }
        sums
    }
}
