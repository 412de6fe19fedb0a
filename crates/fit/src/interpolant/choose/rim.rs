//! How much of the change toward the outermost incidences goes on past them.

use bsdfkit::{DVec3, Result};

use crate::interpolant::choose::left_out::{Energies, binned, error, spread};
use crate::interpolant::choose::select::worse;
use crate::interpolant::component::fitted::Fitted;
use crate::interpolant::component::planned::{Peaks, Planned};
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::interpolant::motion::hypothesis::{Motion, ONWARD};
use crate::lobe::leaves::Leaf;
use bsdfkit_measure::Measurement;

/// The largest of [`ONWARD`] with which the outermost incidences are foretold from the others as well as with any, within a
/// standard error: they are farther past these than most of what will be asked for is past them.
///
/// All are left out at once: one alone is foretold by those beside it. 0 where fewer than two are left.
pub(super) fn onward(m: &Measurement, motion: Motion, fit: &Fitted) -> Result<f64> {
    let fitted = &fit.incidences;
    let outermost =
        IncidenceMesh::in_chart(&fit.directions(), m.symmetry, motion.chart)?.outermost();
    let rest = (0..fitted.len()).filter(|k| !outermost.contains(k));
    let rest: Vec<FittedIncidence> = rest.map(|k| fitted[k].clone()).collect();
    if rest.len() < 2 {
        return Ok(0.0);
    }
    let foretold = spread(m, outermost, |k| fitted[k].hemispherical);
    let truth = foretold.into_iter().map(|k| (fitted[k].wi, binned(m, k)));
    let truth: Vec<(DVec3, Vec<Leaf>)> = truth.collect();
    let roots = |onward: f64| -> Result<Vec<f64>> {
        let motion = Motion { onward, ..motion };
        let c = Planned::new(fit.with(rest.clone()), motion, Peaks::Apart)?;
        let one = |(wi, truth): &(DVec3, Vec<Leaf>)| error(&c, *wi, truth, Energies::Alike).sqrt();
        Ok(truth.iter().map(one).collect())
    };
    let tried = ONWARD.map(|onward| roots(onward).map(|roots| (onward, roots)));
    let tried: Vec<(f64, Vec<f64>)> = tried.into_iter().collect::<Result<_>>()?;
    Ok(farthest(&tried))
}

/// The largest share whose errors are as small as the least, within a standard error.
fn farthest(tried: &[(f64, Vec<f64>)]) -> f64 {
    let sum = |errors: &[f64]| errors.iter().sum::<f64>();
    let least = tried.iter().map(|t| &t.1).min_by(|a, b| sum(a).total_cmp(&sum(b)));
    let as_well = |t: &&(f64, Vec<f64>)| least.is_some_and(|least| !worse(&t.1, least, 1.0));
    tried.iter().filter(as_well).map(|t| t.0).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn change_goes_on_unless_that_is_surely_worse() {
        let errors = |share: f64, errors: [f64; 3]| (share, errors.to_vec());
        let (none, half) = (errors(0.0, [0.20, 0.22, 0.24]), errors(0.5, [0.19, 0.21, 0.23]));
        let among = |all: [f64; 3]| farthest(&[none.clone(), half.clone(), errors(1.0, all)]);
        assert_eq!(among([0.17, 0.24, 0.23]), 1.0);
        assert_eq!(among([0.21, 0.24, 0.25]), 0.5);
        assert_eq!(farthest(&[none.clone(), errors(1.0, [0.23, 0.25, 0.28])]), 0.0);
        // One alone decides outright.
        assert_eq!(farthest(&[(0.0, vec![0.2]), (1.0, vec![0.21])]), 0.0);
        assert_eq!(farthest(&[(0.0, vec![0.2]), (1.0, vec![0.19])]), 1.0);
    }
}
