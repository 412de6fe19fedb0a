//! The continuous BSDF of one (incident side, scattered side) pair.

use std::sync::Arc;

use bsdfkit::render::{Chart, Fold};
use bsdfkit::spectrum::{Basis, Hue, View};
use bsdfkit::{DVec3, Error, Result, Side};
use bsdfkit_sphere::locate::Location;

use crate::interpolant::answer::distribution::Distribution;
use crate::interpolant::answer::seen::{Seen, SeenSlice};
use crate::interpolant::component::fitted::Fitted;
use crate::interpolant::component::located::Asked;
use crate::interpolant::component::planned::{Peaks, Planned};
use crate::interpolant::family::followed::FollowedPeaks;
use crate::interpolant::field::cells::Cells;
use crate::interpolant::field::energy::Energy;
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::mesh::incidence_mesh::{IncidenceMesh, ON_MESH};
use crate::interpolant::motion::hypothesis::Motion;
use bsdfkit_measure::{Mirror, Symmetry};
use bsdfkit_represent::{Followed, Slice, Source};

/// Constant, slope, and centres with weights of the energy correction.
pub(crate) type EnergyParts = (f64, f64, Vec<[f64; 4]>);

/// Fitted incidences, planned and balanced: the last step.
///
/// Incidences are fitted ([`Fitted`]), then meshed and planned with one hypothesis of motion, then their energy is made
/// a smooth function of the incident direction. Each step has all of the one before; nothing is changed afterwards.
#[derive(Clone, Debug)]
pub struct Component {
    /// L1 to expect half-way between incidences; `None` where that was not looked for, or too few could be left out. See
    /// [`expected_between`](crate::validate::expected_between).
    pub expected_error: Option<f64>,
    planned: Arc<Planned>,
    energy: Energy,
    /// The logarithm of the energy correction inside the mesh.
    inside: Cells,
    /// What queries make of bands, where there are bands.
    seen: Option<Seen>,
}

impl Component {
    /// Meshes the fitted incidences, plans how lobes move as `motion` says, and balances the energy between incidences.
    ///
    /// Errors: format where incidences cannot be meshed.
    /// Cost: milliseconds an incidence.
    pub fn new(fitted: Fitted, motion: Motion) -> Result<Self> {
        let planned = Planned::new(fitted, motion, Peaks::Apart)?;
        let energy = Energy::of(&planned);
        Ok(Self::balanced(planned, energy))
    }

    /// The same with energy as it is for incident directions within the chord `reach(mesh)` of `wi` only.
    ///
    /// Cost: that of the mesh about `wi`.
    pub(crate) fn about(
        fitted: Fitted,
        motion: Motion,
        wi: DVec3,
        reach: impl Fn(&IncidenceMesh) -> f64,
    ) -> Result<Self> {
        let planned = Planned::new(fitted, motion, Peaks::Apart)?;
        let energy = Energy::about(&planned, wi, reach(&planned.mesh));
        Ok(Self::balanced(planned, energy))
    }

    /// Of what was kept: fitted incidences, how lobes move, and the energy correction.
    ///
    /// Errors: format where incidences cannot be meshed.
    /// Cost: about 0.1 ms an edge of the mesh.
    pub(crate) fn restored(
        fitted: Fitted,
        motion: Motion,
        (constant, slope, centres): &EnergyParts,
    ) -> Result<Self> {
        let planned = Planned::new(fitted, motion, Peaks::Apart)?;
        Ok(Self::balanced(planned, Energy::from_parts(*constant, *slope, centres)))
    }

    /// With an energy correction that is known.
    pub(crate) fn balanced(planned: Planned, energy: Energy) -> Self {
        let inside = Cells::through(&planned.mesh, |wi| energy.logarithm(wi));
        let seen = planned.fitted.spectra.as_ref().map(|spectra| Seen::usual(spectra.bands()));
        Self { expected_error: None, planned: planned.into(), energy, inside, seen }
    }

    /// The same, of which queries and tables have what `view` makes of its bands; all bands are kept.
    ///
    /// A spectrum is seen in colour (daylight, adapted to equal energy) unless another view is asked for, and as the mean of its
    /// bands where they do not cover the visible.
    ///
    /// Errors: argument, without bands, and as [`View::weights`].
    /// Cost: little; what was fitted is shared.
    pub fn seen_as(&self, view: View) -> Result<Self> {
        let Some(spectra) = self.spectra() else {
            return Err(Error::argument(format!(
                "{view}: expected a spectral measurement, found no bands"
            )));
        };
        Ok(Self { seen: Some(Seen::new(view, spectra.bands())?), ..self.clone() })
    }

    /// What its bands are made of, if it has bands.
    pub fn spectra(&self) -> Option<&Basis> {
        self.fitted().spectra.as_deref()
    }

    /// What queries make of its bands, if it has bands.
    pub fn view(&self) -> Option<View> {
        self.seen.as_ref().map(|seen| seen.view)
    }

    /// f in 1/sr of every band at each of `wo`; `out`: (`wo.len()`, bands). Without bands nothing is written.
    ///
    /// Cost: that of as many values, and some nanoseconds a band.
    pub fn spectra_at(&self, wi: DVec3, wo: &[DVec3], out: &mut [f64]) {
        let Some(spectra) = self.spectra() else { return };
        let bands = spectra.bands().count();
        if let [wo] = wo {
            let mut all = vec![0.0; 1 + bands];
            self.asked(wi, Some(*wo)).eval_channels(*wo, &mut all);
            return out.iter_mut().zip(&all[1..]).for_each(|(out, v)| *out = *v);
        }
        let mut all = vec![0.0; (1 + bands) * wo.len()];
        Slice::eval(&self.at(wi), wo, &mut all);
        for (out, all) in out.chunks_exact_mut(bands).zip(all.chunks_exact(1 + bands)) {
            out.iter_mut().zip(&all[1..]).for_each(|(out, v)| *out = f64::from(*v));
        }
    }

    /// Side of the incident directions.
    pub fn incident(&self) -> Side {
        self.fitted().incident
    }

    /// Side of the scattered directions.
    pub fn scattered(&self) -> Side {
        self.fitted().scattered
    }

    /// Symmetry of the specimen.
    pub fn symmetry(&self) -> Symmetry {
        self.fitted().symmetry
    }

    /// How lobes move between incidences.
    pub fn motion(&self) -> Motion {
        self.planned.motion
    }

    /// The measured incidences.
    pub fn incidences(&self) -> &[FittedIncidence] {
        &self.fitted().incidences
    }

    /// What was fitted.
    pub fn fitted(&self) -> &Fitted {
        &self.planned.fitted
    }

    pub(crate) fn energy(&self) -> &Energy {
        &self.energy
    }

    /// The mesh of the measured incidences and their images, turned to the front.
    pub fn mesh(&self) -> &IncidenceMesh {
        &self.planned.mesh
    }

    /// Its families: peaks that are followed over all incident directions.
    ///
    /// Cost: about 0.1 s.
    pub fn families(&self) -> impl Followed + '_ {
        FollowedPeaks::of(self, &chart_of(self.symmetry()))
    }

    /// Whether an incident direction lies inside the mesh of measured ones.
    pub fn is_measured(&self, wi: DVec3) -> bool {
        self.planned.is_measured(wi)
    }

    /// The scattered distribution of incident direction `wi`.
    ///
    /// Cost: 3–20 µs, then 0.2–0.5 µs a value, and half of that where a [`Slice`](bsdfkit_represent::Slice) takes many;
    /// past the rim of the mesh twice that. One value alone: [`Source::value`].
    pub fn at(&self, wi: DVec3) -> Distribution<'_> {
        self.asked(wi, None)
    }

    fn asked(&self, wi: DVec3, toward: Option<DVec3>) -> Distribution<'_> {
        let energy = |folded, on_mesh, location| self.scale(folded, on_mesh, location);
        self.planned.asked(wi, Asked { energy: &energy, toward })
    }

    /// The energy correction at `folded`. Inside the mesh it bends at the edges of cells, where the
    /// moved lobes' energy does, so that their product hardly bends; past the rim it is smooth.
    fn scale(&self, folded: DVec3, on_mesh: DVec3, location: Location) -> f64 {
        let past = match location {
            Location::Outside { distance, .. } if distance > ON_MESH => {
                self.energy.logarithm(folded) - self.energy.logarithm(on_mesh)
            }
            _ => 0.0,
        };
        Energy::factor(self.inside.at(self.mesh(), location) + past)
    }
}

/// A chart on which peaks are followed, folded as incident directions of that symmetry are.
fn chart_of(symmetry: Symmetry) -> Chart {
    const INTERVALS: [usize; 2] = [24, 64];
    let fold = match symmetry {
        Symmetry::Isotropic => Fold::Isotropic,
        Symmetry::Quadrilateral => Fold::Quadrants,
        Symmetry::Bilateral(Mirror::X) => Fold::MirrorX,
        Symmetry::Bilateral(Mirror::Y) => Fold::MirrorY,
        Symmetry::Rotational180 => Fold::HalfTurn,
        Symmetry::None => Fold::None,
    };
    let intervals = INTERVALS[usize::from(fold.is_isotropic())];
    Chart::new(fold, intervals, 1.0).expect("few intervals")
}

impl Source for Component {
    fn incident(&self) -> Side {
        self.fitted().incident
    }

    fn scattered(&self) -> Side {
        self.fitted().scattered
    }

    fn isotropic(&self) -> bool {
        self.symmetry() == Symmetry::Isotropic
    }

    fn channels(&self) -> usize {
        match &self.seen {
            Some(seen) => seen.channels(),
            None => self.incidences().first().map_or(1, |i| i.details.len()),
        }
    }

    fn is_measured(&self, wi: DVec3) -> bool {
        Component::is_measured(self, wi)
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        match &self.seen {
            Some(seen) => Box::new(SeenSlice { of: self.at(wi), seen }),
            None => Box::new(self.at(wi)),
        }
    }

    fn value(&self, wi: DVec3, wo: DVec3, out: &mut [f32]) {
        let here = self.asked(wi, Some(wo));
        match &self.seen {
            Some(seen) => SeenSlice { of: here, seen }.eval(&[wo], out),
            None => Slice::eval(&here, &[wo], out),
        }
    }

    fn hue(&self) -> Option<Hue> {
        let seen = self.seen.as_ref().filter(|seen| seen.usual)?;
        Hue::new(self.spectra()?.clone(), seen.luminance(), self.fitted().epsilon).ok()
    }

    fn spectra(&self, wi: DVec3, wo: &[DVec3], out: &mut [f64]) {
        self.spectra_at(wi, wo, out);
    }

    fn followed(&self, chart: &Chart) -> Option<Box<dyn Followed + '_>> {
        Some(Box::new(FollowedPeaks::of(self, chart)))
    }
}
