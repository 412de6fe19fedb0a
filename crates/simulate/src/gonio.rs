//! A virtual goniophotometer: irregular points in sweeps and spirals, noise, a retro hole and a grazing limit.

use bsdfkit::{Error, Result};
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::{DVec3, Side};

use crate::material::{Material, SymmetryHint, hemisphere};
use crate::random::Random;

/// An instrument that moves a detector on great circles over the sample, then around each bright peak.
///
/// The defaults give about 50,000 points an incidence, as laboratories do.
#[derive(Clone, Debug)]
pub struct Goniophotometer {
    /// Between incident azimuths, where the material's symmetry asks for several.
    pub azimuth_step_degrees: f64,
    /// Great circles through the normal, 180° / `sweeps` apart and drifting.
    pub sweeps: usize,
    /// Points on each.
    pub points_per_sweep: usize,
    /// Points in the spiral around the brightest peak; the others get half of it.
    pub spiral_points: usize,
    /// Standard deviation of the noise, as a fraction of the value.
    pub relative_noise: f64,
    /// Standard deviation of the noise where there is no light, 1/sr.
    pub absolute_noise: f64,
    /// In reflection the detector may come no nearer to the light than this.
    pub retro_hole_degrees: f64,
    /// The largest scattered angle from the normal.
    pub grazing_limit_degrees: f64,
    /// Diameter of the cone that the detector sees at once: what widens a peak that has no width. Of all else it
    /// sees the value in its middle.
    pub aperture_degrees: f64,
    /// The specimen is mounted back to front, turned by 180° about its up axis, (x, y, z) → (−x, y, −z): what it does on
    /// its front is written as what is seen on the back.
    pub back_to_front: bool,
    /// The same seed gives the same points and noise.
    pub seed: u64,
}

impl Default for Goniophotometer {
    fn default() -> Self {
        Self {
            azimuth_step_degrees: 30.0,
            sweeps: 90,
            points_per_sweep: 360,
            spiral_points: 9000,
            relative_noise: 0.0,
            absolute_noise: 0.0,
            retro_hole_degrees: 4.0,
            grazing_limit_degrees: 82.0,
            aperture_degrees: 1.0,
            back_to_front: false,
            seed: 1,
        }
    }
}

/// The points of one incidence.
#[derive(Clone, Debug)]
pub struct Scan {
    /// Incident direction.
    pub wi: DVec3,
    /// Scattered directions, away from the surface.
    pub wo: Vec<DVec3>,
    /// f with noise, 1/sr, one a direction.
    pub values: Vec<f64>,
    /// The same at each of [`Material::wavelengths`], wavelengths fastest.
    pub bands: Vec<f64>,
}

/// A spiral reaches this far from its peak, in this many turns: half a degree between turns.
const SPIRAL_DEGREES: f64 = 13.0;
const SPIRAL_TURNS: f64 = 26.0;

/// About a peak that has no width the detector goes so many apertures far, in so many turns and points: a sixth of an
/// aperture between turns.
const PEAK_APERTURES: f64 = 2.0;
const PEAK_TURNS: f64 = 12.0;
const PEAK_POINTS: usize = 600;

/// Peaks get spirals when they hold this part of the largest, and are this far apart.
const PEAK_PART: f64 = 0.15;
const PEAK_APART_DEGREES: f64 = 12.0;
const MOST_PEAKS: usize = 3;

/// Points an incidence: above, a typing error is likelier than an instrument.
const MOST_POINTS: usize = 20_000_000;

impl Goniophotometer {
    /// Whether every setting makes sense.
    ///
    /// Errors: class argument, naming the setting; class limit for more than 20 million points an incidence.
    pub fn validate(&self) -> Result<()> {
        let ranges = [
            ("azimuth step", self.azimuth_step_degrees, 1.0, 90.0),
            ("relative noise", self.relative_noise, 0.0, 10.0),
            ("absolute noise", self.absolute_noise, 0.0, 1e6),
            ("retro hole", self.retro_hole_degrees, 0.0, 45.0),
            ("grazing limit", self.grazing_limit_degrees, 10.0, 89.9),
            ("aperture", self.aperture_degrees, 0.01, 20.0),
        ];
        for (name, value, low, high) in ranges {
            if !(low..=high).contains(&value) {
                return Err(Error::argument(format!(
                    "{name}: expected {low} to {high}, found {value}"
                )));
            }
        }
        if self.sweeps < 2 || self.points_per_sweep < 2 {
            return Err(Error::argument(format!(
                "expected at least 2 sweeps of 2 points, found {} of {}",
                self.sweeps, self.points_per_sweep
            )));
        }
        let swept = self.sweeps.checked_mul(self.points_per_sweep);
        let points = swept.and_then(|p| p.checked_add(self.spiral_points.checked_mul(2)?));
        if points.is_none_or(|p| p > MOST_POINTS) {
            return Err(Error::limit(format!(
                "expected at most {MOST_POINTS} points an incidence"
            )));
        }
        Ok(())
    }

    /// (θ, φ) in degrees of the incidences that the material's symmetry asks for.
    pub fn incidences(&self, material: &dyn Material) -> Vec<(f64, f64)> {
        let (range, closed) = match material.symmetry() {
            SymmetryHint::Isotropic => (0.0, true),
            SymmetryHint::Quadrilateral => (90.0, true),
            SymmetryHint::Bilateral => (180.0, true),
            SymmetryHint::None => (360.0, false),
        };
        // whole steps that end on the mirror plane
        let steps = (range / self.azimuth_step_degrees - 1e-9).ceil().max(0.0);
        let count = steps as usize + usize::from(closed);
        let mut incidences = Vec::new();
        for theta in material.polar_angles() {
            if theta == 0.0 {
                incidences.push((0.0, 0.0));
                continue;
            }
            for k in 0..count {
                incidences.push((theta, if k == 0 { 0.0 } else { range * k as f64 / steps }));
            }
        }
        incidences
    }

    /// `w` as the instrument has it.
    pub(crate) fn mounted(&self, w: DVec3) -> DVec3 {
        if self.back_to_front { DVec3::new(-w.x, w.y, -w.z) } else { w }
    }

    /// Measures one incidence; a pure function of the settings, the material and the angles.
    pub fn scan(&self, material: &dyn Material, theta_degrees: f64, phi_degrees: f64) -> Scan {
        let mut random = self.generator(material, theta_degrees, phi_degrees);
        let wi = from_degrees(theta_degrees, phi_degrees);
        let side = material.scattered();
        let mut wo = self.swept(side, &mut random);
        for (rank, peak) in self.peaks(material, wi).into_iter().enumerate() {
            let points = if rank == 0 { self.spiral_points } else { self.spiral_points / 2 };
            spiral(peak, points, &mut random, &mut wo);
        }
        let beams = material.peaks(wi);
        for beam in &beams {
            let radius = PEAK_APERTURES * self.aperture_degrees;
            spiral_within(beam.wo, (radius, PEAK_TURNS), PEAK_POINTS, &mut random, &mut wo);
        }
        let horizon = self.grazing_limit_degrees.to_radians().cos();
        let hole = self.retro_hole_degrees.to_radians().cos();
        wo.retain(|w| w.z * side.sign() >= horizon && (side == Side::Back || w.dot(wi) < hole));
        let mut noisy = |f: f64| {
            let relative = self.relative_noise * random.normal();
            f * (1.0 + relative) + self.absolute_noise * random.normal()
        };
        let beam = |w: DVec3| beams.iter().map(|b| b.seen(w, self.aperture_degrees)).sum::<f64>();
        let values = wo.iter().map(|&w| noisy(material.eval(wi, w) + beam(w))).collect();
        let wavelengths = material.wavelengths();
        let at = |w: DVec3| wavelengths.iter().map(move |&n| material.eval_at(wi, w, n));
        let bands = wo.iter().flat_map(|&w| at(w).map(move |f| f + beam(w))).map(noisy).collect();
        Scan { wi, wo, values, bands }
    }

    /// A generator of its own for each incidence: adding one does not change the others.
    fn generator(&self, material: &dyn Material, theta: f64, phi: f64) -> Random {
        let name = material.name().bytes().map(u64::from);
        let words = name.chain([theta.to_bits(), phi.to_bits()]);
        words.fold(Random::new(self.seed), |r, word| {
            let mut r = r;
            Random::new(r.word() ^ word)
        })
    }

    /// Great circles through the normal, jittered along and drifting aside.
    fn swept(&self, side: Side, random: &mut Random) -> Vec<DVec3> {
        let mut points = Vec::with_capacity(self.sweeps * self.points_per_sweep);
        let step = 2.0 / (self.points_per_sweep - 1) as f64;
        for sweep in 0..self.sweeps {
            let phi = 180.0 * (sweep as f64 + random.between(-0.3, 0.3)) / self.sweeps as f64;
            let drift = random.between(-1.5, 1.5);
            let (wave, phase) = (random.between(-0.7, 0.7), random.between(0.0, 6.0));
            for k in 0..self.points_per_sweep {
                let s = -1.0 + step * (k as f64 + random.between(-0.4, 0.4));
                let s = s.clamp(-1.0, 1.0);
                let aside = drift * s + wave * (3.0 * s + phase).sin();
                let mut w = from_degrees(self.grazing_limit_degrees * s, phi + aside);
                w.z *= side.sign();
                points.push(w);
            }
        }
        points
    }

    /// The brightest directions (as f |cos θo|), at most three, apart from each other.
    fn peaks(&self, material: &dyn Material, wi: DVec3) -> Vec<DVec3> {
        const CELLS: usize = 192;
        let horizon = self.grazing_limit_degrees.to_radians().cos();
        let apart = PEAK_APART_DEGREES.to_radians().cos();
        let mut light: Vec<(f64, DVec3)> = hemisphere(CELLS, material.scattered())
            .filter(|w| w.z.abs() >= horizon)
            .map(|w| (material.eval(wi, w) * w.z.abs(), w))
            .collect();
        light.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut peaks: Vec<DVec3> = Vec::new();
        for &(value, w) in &light {
            if peaks.len() == MOST_PEAKS || value < PEAK_PART * light[0].0 {
                break;
            }
            if peaks.iter().all(|p| p.dot(w) <= apart) {
                peaks.push(w);
            }
        }
        peaks
    }
}

/// Appends an Archimedean spiral of even density around `peak`.
fn spiral(peak: DVec3, points: usize, random: &mut Random, into: &mut Vec<DVec3>) {
    spiral_within(peak, (SPIRAL_DEGREES, SPIRAL_TURNS), points, random, into);
}

/// [`spiral`] as wide, in degrees, and of as many turns as said.
fn spiral_within(
    peak: DVec3,
    (radius, turns): (f64, f64),
    points: usize,
    random: &mut Random,
    into: &mut Vec<DVec3>,
) {
    let (u, v) = peak.any_orthonormal_pair();
    let start = random.between(0.0, std::f64::consts::TAU);
    for k in 0..points {
        let t = ((k as f64 + random.unit()) / points as f64).sqrt();
        let (sin, cos) = (radius * t).to_radians().sin_cos();
        let (y, x) = (std::f64::consts::TAU * turns * t + start).sin_cos();
        into.push((cos * peak + sin * (x * u + y * v)).normalize());
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::to_degrees;

    use super::*;
    use crate::material::{BrushedMetal, Fabric, FrittedGlass, RotatedMetal};

    #[test]
    fn incidences_follow_the_symmetry() {
        let gonio = Goniophotometer::default();
        let count = |m: &dyn Material| gonio.incidences(m).len();
        assert_eq!(count(&FrittedGlass::default()), 6);
        assert_eq!(count(&BrushedMetal::default()), 1 + 5 * 4);
        assert_eq!(count(&Fabric::default()), 1 + 5 * 7);
        assert_eq!(count(&RotatedMetal::default()), 1 + 5 * 12);
        // a step that does not divide the quadrant still ends on its mirror plane
        let odd = Goniophotometer { azimuth_step_degrees: 40.0, ..gonio };
        let last = *odd.incidences(&BrushedMetal::default()).last().unwrap();
        assert_eq!(last, (75.0, 90.0));
    }

    #[test]
    fn points_keep_out_of_the_hole_and_the_horizon() {
        let gonio = Goniophotometer { sweeps: 30, points_per_sweep: 90, ..Default::default() };
        let scan = gonio.scan(&BrushedMetal::default(), 30.0, 60.0);
        assert!(scan.wo.len() > 10_000 && scan.wo.len() == scan.values.len());
        for w in &scan.wo {
            assert!((w.length() - 1.0).abs() < 1e-12);
            assert!(to_degrees(*w).0 <= 82.0 + 1e-9);
            assert!(w.angle_between(scan.wi).to_degrees() > 4.0 - 1e-9);
        }
        let nearest = scan.wo.iter().map(|w| w.angle_between(scan.wi).to_degrees());
        assert!(nearest.fold(90.0, f64::min) < 5.0, "the sweeps pass by the hole");
    }

    #[test]
    fn the_peak_has_the_densest_points() {
        let gonio = Goniophotometer::default();
        let scan = gonio.scan(&FrittedGlass::default(), 45.0, 0.0);
        let within = |center: DVec3, degrees: f64| {
            scan.wo.iter().filter(|w| w.angle_between(center).to_degrees() < degrees).count()
        };
        let peak = -scan.wi;
        let aside = from_degrees(135.0, 90.0);
        assert!(within(peak, 5.0) > 4 * within(aside, 5.0));
    }

    #[test]
    fn the_seed_decides_and_noise_has_its_size() {
        let quiet = Goniophotometer { sweeps: 40, points_per_sweep: 100, ..Default::default() };
        let noisy = Goniophotometer { relative_noise: 0.05, ..quiet.clone() };
        let metal = Fabric::default();
        let (a, b) = (noisy.scan(&metal, 30.0, 0.0), noisy.scan(&metal, 30.0, 0.0));
        assert_eq!(a.values, b.values);
        let other = Goniophotometer { seed: 2, ..noisy.clone() }.scan(&metal, 30.0, 0.0);
        assert_ne!(a.values[..10], other.values[..10]);
        let truth = a.wo.iter().map(|&w| metal.eval(a.wi, w));
        let squares: f64 = a.values.iter().zip(truth).map(|(v, f)| (v / f - 1.0).powi(2)).sum();
        let deviation = (squares / a.values.len() as f64).sqrt();
        assert!((deviation - 0.05).abs() < 0.002, "{deviation}");
    }

    #[test]
    fn senseless_settings_are_refused() {
        let message = |g: Goniophotometer| g.validate().unwrap_err().to_string();
        let base = Goniophotometer::default;
        assert!(message(Goniophotometer { relative_noise: f64::NAN, ..base() }).contains("NaN"));
        assert!(message(Goniophotometer { sweeps: 0, ..base() }).contains("sweeps"));
        let huge = Goniophotometer { sweeps: usize::MAX, ..base() };
        assert!(message(huge).contains("at most"));
    }
}
