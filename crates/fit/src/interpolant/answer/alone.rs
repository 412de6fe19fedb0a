//! One fitted incidence asked by itself.

use bsdfkit::DVec2;

use crate::interpolant::answer::distribution::{Corner, Distribution};
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::motion::cell_movers::Movers;
use crate::interpolant::motion::edge_plan::EdgePlan;
use bsdfkit_measure::Image;
use bsdfkit_measure::frame::FrameAt;

impl FittedIncidence {
    /// The scattering of this incident direction, as it was fitted in a frame that is `at` there; of a spectrum the guide.
    pub(crate) fn distribution<'a>(&'a self, at: &'a FrameAt, epsilon: f64) -> Distribution<'a> {
        let corner = |weight: f64| Corner::new(self, at, weight, false);
        let set = &self.lobes;
        // Every lobe stays.
        let pairs = Movers::of_edge([set, set], &EdgePlan::staying(set));
        Distribution {
            fold: Image::IDENTITY,
            scale: 1.0,
            frame: *at,
            floor: set.floor,
            epsilon,
            moved: pairs.at([set; 3], [1.0, 0.0, 0.0], &|_, _| DVec2::ZERO, None),
            corners: [corner(1.0), corner(0.0), corner(0.0)],
            spectra: None,
            laws: Vec::new(),
            twin: None,
            inner: None,
        }
    }
}
