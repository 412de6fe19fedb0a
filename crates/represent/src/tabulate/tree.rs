//! Continuous BSDF → tensor tree. [WKB14 §2.3]

use std::f64::consts::PI;

use bsdfkit::tree::{Rank, TensorTree};
use bsdfkit::{NEGLIGIBLE_TOTAL, Result};
use bsdfkit_sphere::Side;

use super::energy;
use super::exchange::Exchanged;
use super::layout::Layout;
use super::missed::Limit;
use super::prune::Pruner;
use super::reciprocity;
use super::tree_sampling::TreeSampling;
use super::tree_settings::{TreeReport, TreeSettings, usual_depth};
use crate::source::Source;
use crate::watch::Watch;

/// Share of `max_error` below which no cell is refined, whatever samples are left. A guess:
/// thousands of cells make an incidence.
const LEAST_SCORE: f64 = 1e-5;

/// Continuous BSDF → tensor tree of at most `max_leaves` values, of `max_error` if these suffice.
///
/// Meaning: leaf values are means over incident and scattered cell, so integrals are kept;
/// refined top-down from the source, then pruned bottom-up, rate against distortion.
/// Convention: see [`Rank`]; the tree is of the source's one (incident, scattered) pair of sides.
/// Accuracy: the stated error is that of unseen incidences to 20 % of itself (tests).
/// Errors: argument for contradictory settings; limit for too deep a tree, or cancelled.
/// Cost: the same tree at any number of threads; 16 k slices and 13 to 33 M values at rank 4, a
/// hundredth of the slices and 4 M values at rank 3.
pub fn tensor_tree(
    source: &dyn Source,
    settings: &TreeSettings,
    watch: &Watch<'_>,
) -> Result<(TensorTree, TreeReport)> {
    let rank = settings.rank.unwrap_or(if source.isotropic() { Rank::Three } else { Rank::Four });
    let usual = usual_depth(rank);
    let plan = TreeSampling::new(source, rank, settings.max_depth.unwrap_or(usual), settings)?;
    let average = reciprocity::applies(settings.reciprocity, source)?;
    let exchanged;
    let source = if average && rank == Rank::Three {
        exchanged = Exchanged::new(source);
        &exchanged
    } else {
        source
    };
    let (tree, report) = pruned_tree(source, &plan, settings, average, watch)?;
    // Half of the values that may be had are not for want of values.
    let wanted = report.error > settings.max_error && report.leaves < plan.max_leaves / 2;
    let default_leaves =
        TreeSettings { max_leaves: None, ..*settings }.budget(rank, usual, source.isotropic()).0;
    if wanted && settings.max_depth.is_none() && plan.max_leaves > default_leaves {
        let deeper = TreeSampling::new(source, rank, usual + 1, settings)?;
        return pruned_tree(source, &deeper, settings, average, watch);
    }
    Ok((tree, report))
}

/// The tree that `plan` leads to; `average`: with its exchange of incident and scattered direction.
fn pruned_tree(
    source: &dyn Source,
    plan: &TreeSampling,
    settings: &TreeSettings,
    average: bool,
    watch: &Watch<'_>,
) -> Result<(TensorTree, TreeReport)> {
    let threshold = plan.threshold(source, LEAST_SCORE * settings.max_error, watch)?;
    let (mut fine, samples) = plan.fine(source, threshold, watch)?;
    if average && plan.layout.0 == Rank::Four {
        fine = reciprocity::average(&fine);
    }
    watch.check()?;
    let fluxes = fine.hemispherical();
    if fluxes.iter().all(|&flux| flux <= NEGLIGIBLE_TOTAL) {
        let mean = fluxes.iter().sum::<f64>() / (fluxes.len() as f64 * PI);
        let tree = TensorTree::constant(plan.layout.0, mean as f32)?;
        let report = TreeReport::negligible(&tree);
        return Ok((tree, TreeReport { slices: 4 * plan.groups(), samples, ..report }));
    }
    let finest = plan.levels.group + 1;
    let pruner =
        Pruner::new(&fine, plan.deepest, &emphasis(plan.layout, finest, source.incident()));
    let light = fine.hemispherical();
    let mut target = settings.max_error;
    let (pruned, tree, energy) = loop {
        let pruned = pruner.search(target, plan.max_leaves);
        watch.check()?;
        let tree = pruner.build(pruned.lambda)?;
        let energy =
            energy::error(&tree, plan.layout, finest, &halves(&light, plan.layout, finest));
        let closer = CLOSER * settings.max_error;
        if energy <= settings.max_error || pruned.error > target || target < closer {
            break (pruned, tree, energy);
        }
        target *= (0.9 * settings.max_error / energy).max(0.5);
    };
    let shallow = plan.deepest < usual_depth(plan.layout.0);
    let otherwise = match samples > plan.max_samples - plan.max_samples / 10 && !shallow {
        true => Limit::Samples(samples),
        false => Limit::Depth(plan.deepest),
    };
    let report = TreeReport {
        error: pruned.error,
        energy_error: energy,
        leaves: pruned.values,
        bytes: pruned.bytes,
        slices: 4 * plan.groups(),
        samples,
        reciprocity: average,
        negligible: false,
        missed: settings.missed(
            pruned.error.max(energy),
            pruned.values,
            plan.max_leaves,
            otherwise,
        ),
    };
    Ok((tree, report))
}

/// Energy is asked for down to an L1 of this share of the largest error.
const CLOSER: f64 = 0.05;

/// At this cosine incidences count no more than at smaller ones.
const LEAST_COSINE: f64 = 0.1;

/// How much errors count by incident cell of `level`: alike for equal solid angles, 1 / cos θ times as much as for equal
/// projected ones. So the few cells at grazing incidence, in which peaks move fast, have leaves.
fn emphasis(layout: Layout, level: u32, side: Side) -> Vec<f64> {
    let of = |z| 1.0 / layout.middle(level, z, side).z.abs().max(LEAST_COSINE);
    (0..layout.incident_cells(level)).map(of).collect()
}

/// What each of the cells of `level` has of those one level above.
fn halves(light: &[f64], layout: Layout, level: u32) -> Vec<f64> {
    let parts = layout.incident_cells(level) / light.len();
    light.iter().flat_map(|&l| std::iter::repeat_n(l, parts)).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use bsdfkit::tree::TreeDistribution;
    use bsdfkit::{DVec2, DVec3, Distribution};

    use super::*;
    use crate::source::Slice;

    /// A peak in the mirror direction, by its standard deviation in the projected disk.
    struct Peak(f64);

    struct At(f64, DVec3);

    impl Source for Peak {
        fn incident(&self) -> Side {
            Side::Front
        }
        fn scattered(&self) -> Side {
            Side::Front
        }
        fn isotropic(&self) -> bool {
            true
        }
        fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
            Box::new(At(self.0, wi))
        }
    }

    impl At {
        fn value(&self, wo: DVec3) -> f64 {
            (-(self.1 + wo).truncate().length_squared() / (2.0 * self.0 * self.0)).exp()
        }
    }

    impl Slice for At {
        fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
            for (out, &wo) in out.iter_mut().zip(wo) {
                *out = self.value(wo) as f32;
            }
        }
    }

    /// L1 of a tree of that source, mean over incidences between two polar angles.
    fn error(tree: &TensorTree, source: &Peak, degrees: [f64; 2]) -> f64 {
        let tree = TreeDistribution::new(tree.clone());
        let incidences = 12;
        let of = |n: usize| {
            let part = (n as f64 + 0.5) / incidences as f64;
            let theta = (degrees[0] + part * (degrees[1] - degrees[0])).to_radians();
            let wi = DVec3::new(theta.sin(), 0.0, theta.cos());
            let (mut wrong, mut all) = (0.0, 0.0);
            for k in 0..20_000 {
                let r = ((f64::from(k) + 0.5) / 20_000.0).sqrt();
                let wo =
                    (DVec2::from_angle(f64::from(k) * 2.399_963) * r).extend((1.0 - r * r).sqrt());
                let f = At(source.0, wi).value(wo);
                wrong += (tree.value(wi, wo) - f).abs();
                all += f;
            }
            wrong / all / incidences as f64
        };
        (0..incidences).map(of).sum()
    }

    /// At as many values: fewer errors where the sun is low, somewhat more where it is high.
    #[test]
    fn grazing_incidences_have_their_share_of_leaves() {
        let source = Peak(0.15);
        let settings = TreeSettings { max_samples: Some(2_000_000), ..TreeSettings::default() };
        let watch = Watch::default();
        let plan = TreeSampling::new(&source, Rank::Three, 7, &settings).unwrap();
        let threshold = plan.threshold(&source, 1e-7, &watch).unwrap();
        let (fine, _) = plan.fine(&source, threshold, &watch).unwrap();
        let finest = plan.levels.group + 1;
        let solid = emphasis(plan.layout, finest, Side::Front);
        let errors = [&solid, &vec![1.0; solid.len()]].map(|emphasis| {
            let pruner = Pruner::new(&fine, plan.deepest, emphasis);
            let pruned = pruner.search(1e-6, 6000);
            let tree = pruner.build(pruned.lambda).unwrap();
            [[74.0, 86.0], [5.0, 50.0]].map(|degrees| error(&tree, &source, degrees))
        });
        let [with, without] = errors;
        println!("grazing {} and {}, else {} and {}", with[0], without[0], with[1], without[1]);
        assert!(with[0] < 0.9 * without[0], "grazing: {errors:?}");
        assert!(with[1] < 1.5 * without[1], "else: {errors:?}");
        // 1 / cos θ of the middle of each cell, but for the last ones.
        let z = |cell| plan.layout.middle(finest, cell, Side::Front).z.abs();
        for (cell, solid) in solid.iter().enumerate() {
            assert!(z(cell) < 0.1 || (solid * z(cell) - 1.0).abs() < 1e-12);
            assert!(*solid <= 10.0 + 1e-9 && *solid >= 1.0 / PI);
        }
    }
}
