//! What tabulation reads: a continuous BSDF, one incident direction at a time.

use bsdfkit::render::Chart;
use bsdfkit::spectrum::Hue;
use bsdfkit_sphere::{DVec2, DVec3, Side};

/// A continuous BSDF f(ωi, ωo) of one (incident side, scattered side) pair.
///
/// Convention: both directions are unit vectors pointing away from the surface.
pub trait Source: Sync {
    /// Side of every incident direction.
    fn incident(&self) -> Side;

    /// Side of every scattered direction.
    fn scattered(&self) -> Side;

    /// Whether f depends on azimuths only by their difference.
    fn isotropic(&self) -> bool;

    /// Number of values per direction; the first is the luminance, which steers refinement.
    fn channels(&self) -> usize {
        1
    }

    /// Whether `wi` lies where f rests on measurements rather than on extrapolation.
    fn is_measured(&self, _wi: DVec3) -> bool {
        true
    }

    /// The scattered distribution of the incident direction `wi`.
    ///
    /// Cost: may be high (50 µs); values of one slice are cheap.
    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a>;

    /// f in 1/sr of one pair of directions, by channel: what the slice says.
    ///
    /// Cost: may be far less than a slice's.
    fn value(&self, wi: DVec3, wo: DVec3, out: &mut [f32]) {
        self.slice(wi).eval(&[wo], out);
    }

    /// How its bands follow from its luminance and a few coefficients, if it has bands that tables are to keep.
    fn hue(&self) -> Option<Hue> {
        None
    }

    /// f in 1/sr of every band, where there is a [`Source::hue`]; `out`: (`wo.len()`, bands).
    fn spectra(&self, _wi: DVec3, _wo: &[DVec3], out: &mut [f64]) {
        out.fill(f64::NAN);
    }

    /// Its peaks, if it knows which is which from one node of `chart` to the next.
    ///
    /// Cost: may be high (0.1 s).
    fn followed(&self, _chart: &Chart) -> Option<Box<dyn Followed + '_>> {
        None
    }
}

/// Peaks that are followed over all incident directions, each by itself: they say where f may be
/// taken apart, and where each part goes.
pub trait Followed: Sync {
    /// How many there are, the brightest first.
    fn count(&self) -> usize;

    /// Where each of them is at an incident direction; `None`: it is not there.
    fn extents(&self, wi: DVec3) -> Vec<Option<Extent>>;

    /// The share of f that is each one's at each of `wo`: (`wo.len()`, count), each row sums to 1.
    fn shares(&self, wi: DVec3, wo: &[DVec3], out: &mut [f32]);
}

/// Middle and covariance of a peak in the disk of scattered directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// x and y of its middle.
    pub centre: DVec2,
    /// xx, xy and yy.
    pub covariance: [f64; 3],
}

/// Where a slice has structure that coarse sampling might miss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Unit vector to its middle.
    pub direction: DVec3,
    /// About one standard deviation along its narrow axis, in the projected disk: radians of the
    /// polar angle times the cosine.
    pub radius: f64,
}

/// The scattered distribution of one incident direction.
pub trait Slice: Sync {
    /// f in 1/sr at each of `wo`.
    ///
    /// Shapes: `out` is (`wo.len()`, channels). Whatever is negative or not finite counts as 0.
    fn eval(&self, wo: &[DVec3], out: &mut [f32]);

    /// Appends the slice's peaks: hints by which tabulation finds what its first samples miss.
    /// Whatever is left out is found by chance or not at all; what is wrong costs samples only.
    fn peaks(&self, _out: &mut Vec<Peak>) {}
}
