//! Peaks followed from node to node of a chart, in coordinates in which they hardly move.

use bsdfkit::DVec2;

/// A lobe at a node, in coordinates of its law.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    pub(crate) mean: DVec2,
    /// Fourth root of the determinant of its covariance.
    pub(crate) width: f64,
    /// Share of the light there.
    pub(crate) mass: f64,
}

impl Item {
    /// How much it tells of where the peak about `middle` is: narrow lobes tell best.
    pub(crate) fn tells(&self, middle: DVec2) -> f64 {
        let variance = self.width * self.width;
        let e = self.mean.distance_squared(middle) / (variance + STRAYED * STRAYED);
        self.mass / variance.max(1e-9) * (-0.5 * e).exp()
    }
}

/// How far from where it is expected a lobe may be and tell much, beside its width.
const STRAYED: f64 = 0.02;

/// A peak moves at most so far from one node to the next.
const STEP: f64 = 0.05;

/// A lobe so many times its width from a middle needs another: tables about that are too coarse for it.
const FAR: f64 = 3.0;

/// A peak has at least so much of the light of all nodes together.
const LEAST: f64 = 0.01;

/// What tells less than this share of what told at the node before tells nothing: the peak is gone, and stays where its law has it.
const GONE: f64 = 0.03;

/// The middles of peaks at every node: (peaks, nodes), at least one of any lobes.
///
/// `nodes`: the lobes of each; `apart`: the square of how far two nodes are apart.
/// Cost: the square of the number of nodes for each peak, a nanosecond each.
pub(crate) fn tracks(
    nodes: &[Vec<Item>],
    apart: impl Fn(usize, usize) -> f64,
    most: usize,
) -> Vec<Vec<DVec2>> {
    let mut found: Vec<Vec<DVec2>> = Vec::new();
    while found.len() < most {
        let open = |n: usize, item: &Item| {
            found.iter().all(|t| t[n].distance(item.mean) > FAR * item.width)
        };
        let left: Vec<Vec<Item>> = nodes
            .iter()
            .enumerate()
            .map(|(n, items)| items.iter().filter(|i| open(n, i)).copied().collect())
            .collect();
        let all: f64 = left.iter().flatten().map(|i| i.mass).sum();
        let least = if found.is_empty() { 0.0 } else { LEAST * nodes.len() as f64 };
        let Some((first, seed)) = seed(nodes, &left).filter(|_| all > least) else { break };
        found.push(track(nodes, &apart, first, &seed));
    }
    found
}

/// The place that most of the light left is near, over all nodes, and the node that tells most of it.
fn seed(nodes: &[Vec<Item>], left: &[Vec<Item>]) -> Option<(usize, Item)> {
    let all: Vec<&Item> = left.iter().flatten().filter(|i| i.mass > 0.0).collect();
    let step = all.len().div_ceil(TRIED).max(1);
    let near = |at: &Item| -> f64 {
        let near = |i: &&&Item| i.mean.distance(at.mean) <= i.width.min(at.width);
        all.iter().filter(near).map(|i| i.mass).sum()
    };
    let tried = all.iter().step_by(step).map(|i| (near(i), **i));
    let (_, place) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let tells = |n: &usize| nodes[*n].iter().map(|i| i.tells(place.mean)).sum::<f64>();
    let node = (0..nodes.len()).max_by(|a, b| tells(a).total_cmp(&tells(b)))?;
    Some((node, place))
}

/// Most places that are tried for one peak.
const TRIED: usize = 300;

/// Where the peak that is at `seed` of node `first` is at all others, each looked for where the nearest that is known has it.
fn track(
    nodes: &[Vec<Item>],
    apart: &impl Fn(usize, usize) -> f64,
    first: usize,
    seed: &Item,
) -> Vec<DVec2> {
    let width = seed.width.max(1e-6);
    let mut at = vec![seed.mean; nodes.len()];
    let mut told = vec![0.0; nodes.len()];
    // The nearest known of each, and how far; of known ones -1.
    let mut near: Vec<(f64, usize)> = (0..nodes.len()).map(|n| (apart(n, first), first)).collect();
    for _ in 0..nodes.len() {
        let ahead = (0..nodes.len()).filter(|&n| near[n].0 >= 0.0);
        let Some(node) = ahead.min_by(|&a, &b| near[a].0.total_cmp(&near[b].0)) else { break };
        let from = near[node].1;
        (at[node], told[node]) = match climbed(&nodes[node], at[from], width) {
            Some((place, tells))
                if tells > GONE * told[from] && place.distance(at[from]) < STEP =>
            {
                (place, tells)
            }
            _ => (at[from], told[from]),
        };
        near[node].0 = -1.0;
        for (n, near) in near.iter_mut().enumerate() {
            let distance = apart(n, node);
            if distance < near.0 {
                *near = (distance, node);
            }
        }
    }
    at
}

/// Where a peak is that has all of these lobes; where it has none, as at the nearest node where it has some.
pub(crate) fn lone(nodes: &[Vec<Item>], apart: impl Fn(usize, usize) -> f64) -> Vec<DVec2> {
    let middle = |items: &Vec<Item>| {
        let weight = |i: &Item| i.mass / (i.width * i.width).max(1e-9);
        let sum: f64 = items.iter().map(weight).sum();
        let place = items.iter().map(|i| weight(i) * i.mean).sum::<DVec2>();
        (sum > 1e-9).then(|| place / sum)
    };
    let known: Vec<(usize, DVec2)> =
        nodes.iter().enumerate().filter_map(|(n, items)| Some((n, middle(items)?))).collect();
    let near = |n: usize| {
        let near = known.iter().min_by(|a, b| apart(a.0, n).total_cmp(&apart(b.0, n)));
        near.map_or(DVec2::ZERO, |k| k.1)
    };
    (0..nodes.len()).map(near).collect()
}

/// Where the peak nearest to `from` has its middle, and how much lobes tell of it.
fn climbed(items: &[Item], from: DVec2, width: f64) -> Option<(DVec2, f64)> {
    let (mut at, mut tells) = (from, 0.0);
    for _ in 0..8 {
        let (mut sum, mut weight) = (DVec2::ZERO, 0.0);
        for item in items {
            // What is as wide as the peak is most likely it.
            let alike = (item.width / width).min(width / item.width);
            let w = item.tells(at) * alike * alike;
            sum += w * item.mean;
            weight += w;
        }
        if weight.is_nan() || weight <= 1e-9 {
            return None;
        }
        (at, tells) = (sum / weight, weight);
    }
    Some((at, tells))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two peaks that part from one, and a broad one.
    #[test]
    fn peaks_that_part_are_followed_each_by_itself() {
        let item = |x: f64, width: f64, mass: f64| Item { mean: DVec2::new(x, 0.0), width, mass };
        let place = |n: usize| 0.01 * n as f64;
        let nodes: Vec<Vec<Item>> = (0..30)
            .map(|n| {
                vec![item(place(n), 0.02, 0.4), item(-place(n), 0.02, 0.4), item(0.0, 0.3, 0.2)]
            })
            .collect();
        let apart = |a: usize, b: usize| (a as f64 - b as f64).powi(2);
        let found = tracks(&nodes, apart, 6);
        assert_eq!(found.len(), 3);
        for (side, n) in [-1.0, 1.0].into_iter().flat_map(|s| (8..30).map(move |n| (s, n))) {
            let end = DVec2::new(side * place(29), 0.0);
            let off = |t: &&Vec<DVec2>| (t[29].distance(end) * 1e6) as i64;
            let own = found.iter().min_by_key(off).expect("a track");
            assert!((own[n].x - side * place(n)).abs() < 0.015, "{side} {n}: {}", own[n]);
        }
        assert!(tracks(&[], apart, 6).is_empty());
    }
}
