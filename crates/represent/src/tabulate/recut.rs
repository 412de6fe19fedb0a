//! Tensor tree → smaller tree of the same rank: pruned as trees are that were sampled.

use bsdfkit::tree::{Rank, Slot, TensorTree};
use bsdfkit::{Error, Result};

use super::cells::{TreeCell, mean};
use super::fine::{Fine, Levels, Node, Subtree};
use super::layout::Layout;
use super::missed::Limit;
use super::prune::Pruner;
use super::tree_settings::{TreeReport, TreeSettings};

/// Level down to which nodes are looked at.
const DEEPEST: u32 = 10;

/// The smallest tree that adds at most `max_error` to `tree`, of at most `max_leaves` values.
///
/// Meaning: leaves hold exact means.
/// Accuracy: the stated L1 is exact for trees of depth 10 at most.
/// Errors: argument, for another rank and for an error that is none.
pub(super) fn recut(
    tree: &TensorTree,
    settings: &TreeSettings,
) -> Result<(TensorTree, TreeReport)> {
    settings.check()?;
    let rank = tree.rank();
    if settings.rank.is_some_and(|asked| asked != rank) {
        let text = "tree: expected the rank of the tree that is cut, found another";
        return Err(Error::argument(text));
    }
    let top = match rank {
        Rank::Three => 4,
        Rank::Four => 3,
    };
    let group = tree.depth().clamp(top + 1, DEEPEST) - 1;
    let levels = Levels { top, group, start: top };
    let layout = Layout(rank);
    let mut fine = Fine { layout, levels, subtrees: Vec::new() };
    let scattered = 1usize << (2 * top);
    let count = layout.incident_cells(top) * scattered;
    fine.subtrees.resize_with(count, || Subtree { nodes: Vec::new() });
    descend(tree, tree.root(), TreeCell::WHOLE, &mut fine);
    let deepest = settings.max_depth.unwrap_or(DEEPEST).min(tree.depth());
    let max_leaves = settings.max_leaves.unwrap_or(usize::MAX);
    let pruner = Pruner::new(&fine, deepest, &fine.alike());
    let pruned = pruner.search(settings.max_error, max_leaves);
    let cut = pruner.build(pruned.lambda)?;
    let report = TreeReport {
        error: pruned.error,
        missed: settings.missed(pruned.error, pruned.values, max_leaves, Limit::Depth(deepest)),
        ..TreeReport::exact(&cut)
    };
    Ok((cut, report))
}

/// Down to the roots of subtrees.
fn descend(tree: &TensorTree, slot: Slot, cell: TreeCell, fine: &mut Fine) {
    let top = fine.levels.top;
    if cell.level == top {
        let mut nodes = vec![Node::terminal(0.0, 0.0)];
        nodes[0] = node(tree, slot, cell, &mut nodes);
        fine.subtrees[(cell.incident << (2 * top)) + cell.scattered] = Subtree { nodes };
        return;
    }
    for c in 0..tree.rank().children() {
        if let Some(child) = cell.child(tree.rank(), c) {
            descend(tree, tree.child(slot, c), child, fine);
        }
    }
}

fn node(tree: &TensorTree, slot: Slot, cell: TreeCell, nodes: &mut Vec<Node>) -> Node {
    if let Slot::Leaf(value) = slot {
        return Node::terminal(value.into(), 0.0);
    }
    if cell.level == DEEPEST {
        let value = mean(tree, slot, cell);
        return Node::terminal(value, spread(tree, slot, cell, value));
    }
    let count = tree.rank().children();
    let first = nodes.len();
    nodes.resize(first + count, Node::terminal(0.0, 0.0));
    let mut sum = 0.0;
    for c in 0..count {
        // Below the top level every child has incident directions.
        let Some(child) = cell.child(tree.rank(), c) else { continue };
        nodes[first + c] = node(tree, tree.child(slot, c), child, nodes);
        sum += f64::from(nodes[first + c].value);
    }
    Node { first: first as u32, ..Node::terminal(sum / count as f64, 0.0) }
}

/// Mean |f − value| over a cell.
fn spread(tree: &TensorTree, slot: Slot, cell: TreeCell, value: f64) -> f64 {
    if let Slot::Leaf(own) = slot {
        return (f64::from(own) - value).abs();
    }
    let count = tree.rank().children();
    let child = |c| {
        let below = cell.child(tree.rank(), c);
        below.map_or(0.0, |cell| spread(tree, tree.child(slot, c), cell, value))
    };
    (0..count).map(child).sum::<f64>() / count as f64
}
