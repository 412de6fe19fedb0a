//! The interpolant of a material: one continuous function a component.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use bsdfkit::limits::read_file;
use bsdfkit::spectrum::{Bands, Basis, Hue, View};
use bsdfkit::{DVec3, Error, Result, Side, Specular};
use bsdfkit_sphere::direction::to_degrees;

use crate::cache::{KeptComponent, Stage};
use crate::interpolant::choose::build::{FitSettings, build_guided, guided};
use crate::interpolant::component::component::Component;
use crate::interpolant::component::coverage::Coverage;
use crate::specular::{Separated, separate};
use crate::validate::expected_between;
use bsdfkit_measure::DenseFile;
use bsdfkit_measure::Measurement;
use bsdfkit_represent::Dense;
use bsdfkit_represent::Watch;
use bsdfkit_represent::sir::{Plans, Sir, SirLimits};
use bsdfkit_represent::{Followed, Slice, Source};

/// A continuous BSDF over the whole 4-D domain, one part for each pair of sides.
#[derive(Clone, Debug, Default)]
pub struct Interpolant {
    /// Name of the specimen.
    pub name: Option<String>,
    /// Parts, no two of the same pair of sides.
    pub components: Vec<Part>,
    /// Peaks of no width, which no part has.
    pub specular: Vec<Specular>,
}

/// One component, whatever it came from.
#[derive(Clone, Debug)]
pub enum Part {
    /// Fitted here.
    Transported(Arc<Component>),
    /// Fitted by Radiance; kept as it was written.
    Sir(SirPart),
    /// A function that a file of another format holds; kept as it was written.
    Dense(DensePart),
}

/// A function on a grid, and the bytes of its file.
#[derive(Clone, Debug)]
pub struct DensePart {
    /// What answers.
    pub function: Arc<dyn Dense>,
    /// The file as it was.
    pub bytes: Arc<[u8]>,
}

/// A Radiance interpolant and the bytes of its file.
#[derive(Clone, Debug)]
pub struct SirPart {
    /// What the bytes say.
    pub sir: Arc<Sir>,
    /// The file as it was.
    pub bytes: Arc<[u8]>,
}

impl Part {
    fn source(&self) -> &dyn Source {
        match self {
            Part::Transported(c) => c.as_ref(),
            Part::Sir(s) => s.sir.as_ref(),
            Part::Dense(d) => d.function.as_ref(),
        }
    }
}

impl Part {
    /// What its bands are made of, if it has bands.
    pub fn spectra(&self) -> Option<&Basis> {
        match self {
            Part::Transported(c) => c.spectra(),
            Part::Sir(_) | Part::Dense(_) => None,
        }
    }

    /// How many incidences were measured.
    pub fn incidences(&self) -> usize {
        match self {
            Part::Transported(c) => c.incidences().len(),
            Part::Sir(s) => s.sir.nodes().len(),
            Part::Dense(d) => d.function.incidences(),
        }
    }
}

impl Source for Part {
    fn incident(&self) -> Side {
        self.source().incident()
    }

    fn scattered(&self) -> Side {
        self.source().scattered()
    }

    fn isotropic(&self) -> bool {
        self.source().isotropic()
    }

    fn channels(&self) -> usize {
        self.source().channels()
    }

    fn is_measured(&self, wi: DVec3) -> bool {
        self.source().is_measured(wi)
    }

    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        self.source().slice(wi)
    }

    fn value(&self, wi: DVec3, wo: DVec3, out: &mut [f32]) {
        self.source().value(wi, wo, out);
    }

    fn hue(&self) -> Option<Hue> {
        self.source().hue()
    }

    fn spectra(&self, wi: DVec3, wo: &[DVec3], out: &mut [f64]) {
        self.source().spectra(wi, wo, out);
    }

    fn followed(&self, chart: &bsdfkit::render::Chart) -> Option<Box<dyn Followed + '_>> {
        self.source().followed(chart)
    }
}

/// Readers refuse what is not finite, but a [`Measurement`] can be made otherwise.
fn expect_finite(m: &Measurement) -> Result<()> {
    for i in &m.incidences {
        let value = i.values.iter().find(|v| !v.is_finite());
        let direction = i.wo.iter().find(|w| !w.is_finite());
        let found = value.map(f32::to_string).or(direction.map(|w| w.to_string()));
        if let Some(found) = found {
            let (theta, phi) = to_degrees(i.wi);
            return Err(Error::argument(format!(
                "incidence theta {theta:.1} phi {phi:.1}: expected finite points, found {found}"
            )));
        }
    }
    Ok(())
}

impl Interpolant {
    /// Fits measured components, one after the other, each on all threads.
    ///
    /// Each component is told the error to expect between incidences. With a [signature](FitSettings::signature) peaks
    /// that the instrument does not resolve are separated first ([`separate`]). With a cache in `settings`, a fit that was stopped
    /// goes on where it was, to the same bits.
    ///
    /// Errors: argument where a point is not finite; limit when cancelled; format where an incidence has too few points
    /// or incidences cannot be meshed.
    /// Cost: about 0.05 s an incidence of 50,000 points.
    pub fn fit(
        measurements: &[Measurement],
        settings: &FitSettings,
        watch: &Watch<'_>,
    ) -> Result<Self> {
        Self::of(measurements.iter().map(Cow::Borrowed), settings, watch)
    }

    /// [`Interpolant::fit`], which needs less memory: bands go as soon as it is known what they add to the guide.
    ///
    /// Errors, cost: as [`Interpolant::fit`].
    pub fn fit_owned(
        measurements: Vec<Measurement>,
        settings: &FitSettings,
        watch: &Watch<'_>,
    ) -> Result<Self> {
        Self::of(measurements.into_iter().map(Cow::Owned), settings, watch)
    }

    /// Takes the parts of `other`, fitted to other components of the same specimen.
    pub fn join(&mut self, other: Self) {
        self.name = self.name.take().or(other.name);
        self.components.extend(other.components);
        self.specular.extend(other.specular);
    }

    fn of<'a>(
        measurements: impl Iterator<Item = Cow<'a, Measurement>>,
        settings: &FitSettings,
        watch: &Watch<'_>,
    ) -> Result<Self> {
        let mut fitted = Self::default();
        for mut m in measurements {
            expect_finite(&m)?;
            m.expect_enough()?;
            fitted.name = fitted.name.or_else(|| m.sample_name.clone());
            if let Some(signature) = &settings.signature {
                let Separated { measurement, peaks } = separate(&m, signature)?;
                fitted.specular.extend(peaks.into_iter().map(|found| found.specular));
                m = Cow::Owned(measurement);
            }
            let stage = Stage::of("component", &m, settings, &());
            let component = match stage.kept::<KeptComponent>(&()) {
                Some(kept) => kept.back()?,
                None => {
                    let (guide, hues) = guided(m);
                    let mut component = build_guided(&guide, hues, settings, watch)?;
                    component.expected_error = expected_between(&guide, &component, watch)?;
                    stage.keep(&(), &KeptComponent::of(&component));
                    component
                }
            };
            fitted.components.push(Part::Transported(component.into()));
        }
        Ok(fitted)
    }

    /// The same, of which queries and tables have what `view` makes of its bands; see [`Component::seen_as`]. Peaks of no
    /// width stay as they are: of a spectrum as they are seen in daylight.
    ///
    /// Errors: argument, where a part has no bands, and as [`View::weights`].
    pub fn seen_as(&self, view: View) -> Result<Self> {
        let seen = |part: &Part| match part {
            Part::Transported(c) => Ok(Part::Transported(c.seen_as(view)?.into())),
            Part::Sir(_) => Err(Error::argument(format!(
                "{view}: expected a spectral measurement, found Radiance's interpolant of three channels at most"
            ))),
            Part::Dense(_) => Err(Error::argument(format!(
                "{view}: expected an interpolant of a spectral measurement, found tables of three channels at most: `fit` makes one"
            ))),
        };
        let components = self.components.iter().map(seen).collect::<Result<_>>()?;
        Ok(Self { name: self.name.clone(), components, specular: self.specular.clone() })
    }

    /// The wavelengths of its bands: of the first part that has some.
    pub fn bands(&self) -> Option<&Bands> {
        self.components.iter().find_map(Part::spectra).map(Basis::bands)
    }

    /// Reads the content of one Radiance interpolant.
    ///
    /// Errors: as [`Sir::from_bytes`].
    pub fn from_sir(bytes: &[u8]) -> Result<Self> {
        let sir = Sir::from_bytes(bytes, Plans::Repaired, SirLimits::default())?;
        let name = Some(sir.name().to_owned()).filter(|name| !name.is_empty());
        let part = Part::Sir(SirPart { sir: sir.into(), bytes: bytes.into() });
        Ok(Self { name, components: vec![part], specular: Vec::new() })
    }

    /// The functions that a file of another format holds, if it is one of these: RGL's tensors, MERL, Zemax. `place` is where the bytes come from, for messages.
    ///
    /// Errors: format.
    pub fn from_tables(place: &str, bytes: &[u8]) -> Option<Result<Self>> {
        let read = |DenseFile { name, functions }| {
            let bytes: Arc<[u8]> = bytes.into();
            let part = |function| Part::Dense(DensePart { function, bytes: bytes.clone() });
            let components = functions.into_iter().map(part).collect();
            Self { name, components, specular: Vec::new() }
        };
        DenseFile::from_bytes(place, bytes).map(|file| file.map(read))
    }

    /// Reads Radiance interpolants, one file a component.
    pub fn read_sir(paths: &[impl AsRef<Path>]) -> Result<Self> {
        let mut interpolant = Self::default();
        for path in paths {
            let path = path.as_ref();
            let limits = SirLimits::default();
            let bytes = read_file(path, limits.bytes)?;
            let sir = Sir::from_bytes(&bytes, Plans::Repaired, limits)
                .map_err(|e| e.context(path.display()))?;
            if interpolant.part(sir.incident(), sir.scattered()).is_some() {
                return Err(Error::argument(format!(
                    "{}: expected one file for each pair of sides, found a second {:?} to {:?}",
                    path.display(),
                    sir.incident(),
                    sir.scattered()
                )));
            }
            if interpolant.name.is_none() && !sir.name().is_empty() {
                interpolant.name = Some(sir.name().to_owned());
            }
            interpolant
                .components
                .push(Part::Sir(SirPart { sir: sir.into(), bytes: bytes.into() }));
        }
        Ok(interpolant)
    }

    /// The part for a pair of sides.
    pub fn part(&self, incident: Side, scattered: Side) -> Option<&Part> {
        self.components.iter().find(|p| p.incident() == incident && p.scattered() == scattered)
    }

    /// How f(wi, wo) was come by; `None` for sides that were not measured, and for Radiance's
    /// interpolants and tables of others, which do not say how far the instrument reached.
    pub fn coverage(&self, wi: DVec3, wo: DVec3) -> Option<Coverage> {
        match self.part(Side::of(wi), Side::of(wo))? {
            Part::Transported(component) => Some(component.coverage(wi, wo)),
            Part::Sir(_) | Part::Dense(_) => None,
        }
    }
}
