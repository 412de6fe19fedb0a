//! An order: what is made of a BSDF for a file, and for whom.

use bsdfkit::component::name_of_sides;
use bsdfkit::spectrum::View;
use bsdfkit::tree::Rank;
use bsdfkit::{Band, Bsdf, Component, Error, Lambertian, Metadata, Result, Side, Specular};

use super::consumer::{Consumer, SOLAR, both_ways, forget_made_up};
use super::kind::Kind;
use super::subject::Subject;
use bsdfkit_represent::Source;
use bsdfkit_represent::Watch;
use bsdfkit_represent::tabulate::{
    self, Form, KlemsSettings, Reciprocity, RenderSettings, Report, Tabulated, TreeSettings,
};

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Order {
    /// The form: trees, matrices or the render form.
    pub kind: Kind,
    /// The program whose rules are kept.
    pub consumer: Option<Consumer>,
    /// [`TreeSettings::max_error`], alone honoured up to [`TreeSettings::MOST_LEAVES`]; of matrices
    /// [`KlemsSettings::tolerance`], of the render form [`RenderSettings::max_error`].
    pub max_error: Option<f64>,
    /// [`TreeSettings::max_leaves`].
    pub max_leaves: Option<usize>,
    /// [`TreeSettings::max_depth`].
    pub max_depth: Option<u32>,
    /// Whether reciprocal values of reflection are averaged: `Auto` in trees made of interpolants alone.
    pub reciprocity: Reciprocity,
    /// What is made of the bands of spectra; `None`: colour in daylight, and for programs that read it the sun's energy beside it.
    pub view: Option<View>,
    /// Whether trees keep the bands of spectra where no view is asked for; the render form does. For XML, which has none, false saves time.
    pub bands: bool,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Delivered {
    /// All bands in their form.
    pub bsdf: Bsdf,
    /// How each component of each band came to its form.
    pub reports: Vec<Report>,
    /// Whether a coloured component was tabulated, in luminance.
    pub loses_colour: bool,
    /// What was left out or made up, a sentence each.
    pub said: Vec<String>,
}

impl Order {
    /// An order of `kind` with the usual settings.
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            consumer: None,
            max_error: None,
            max_leaves: None,
            max_depth: None,
            reciprocity: Reciprocity::Auto,
            view: None,
            bands: true,
        }
    }

    /// Everything of `subject` in the form asked for, fitted to whom it is for.
    ///
    /// Components that have that form are copied value by value, further bands converted alike.
    ///
    /// Errors: argument for [`Kind::Interpolant`], and as the tabulation; limit when cancelled.
    pub fn deliver(
        &self,
        subject: Subject<'_>,
        mut metadata: Metadata,
        watch: &Watch<'_>,
    ) -> Result<Delivered> {
        if self.kind.channels().is_some() {
            return Err(Error::argument(
                "RGL's tables are a file of their own: expected a tree or a matrix to be made",
            ));
        }
        if self.kind == Kind::Interpolant {
            return Err(Error::argument(
                "an interpolant is made of measurements: expected a tree, a matrix or the render form to be made",
            ));
        }
        let viewed = match (subject, self.view) {
            (Subject::Continuous(interpolant), Some(view)) => Some(interpolant.seen_as(view)?),
            (Subject::Stored(_), Some(view)) => {
                return Err(Error::argument(format!(
                    "{view}: expected the interpolant of a spectral measurement, found a stored BSDF"
                )));
            }
            _ => None,
        };
        let subject = viewed.as_ref().map_or(subject, Subject::Continuous);
        let mut made = self.visible(subject, watch)?;
        let copied = |report: &Report| *report == Report::Copied;
        let same_structure = made.reports.iter().all(copied);

        let further = match subject {
            Subject::Stored(bsdf) => bsdf.bands(),
            Subject::Continuous(_) => &[],
        };
        let (wanted, left_out): (Vec<&Band>, Vec<&Band>) =
            further.iter().partition(|band| self.consumer.is_none_or(|c| c.wants(band)));
        let mut bands = Vec::new();
        for band in wanted {
            let components = band.components.clone();
            let alone = Bsdf::new(Metadata::default(), components, Lambertian::default());
            let alone = self.visible(Subject::Stored(&alone), watch)?;
            made.reports.extend(alone.reports);
            let components = alone.bsdf.components().to_vec();
            bands.push(Band { components, ..band.clone() });
        }
        bands.extend(self.solar(subject, watch)?);
        let mut lost: Vec<String> = left_out.iter().map(|b| format!("band {}", b.name)).collect();
        if !same_structure || self.consumer.is_some() {
            lost.extend(metadata.bound());
            metadata = metadata.unbound();
        }
        forget_made_up(&mut metadata, &bands);
        if !lost.is_empty() {
            made.said.push(format!("left out: {}", lost.join(", ")));
        }
        let (components, explicit) =
            (made.bsdf.components().to_vec(), *made.bsdf.explicit_lambertian());
        let peaks = made.bsdf.specular().to_vec();
        made.bsdf =
            Bsdf::new(metadata, components, explicit).with_bands(bands).with_specular(peaks);
        if let Some(consumer) = self.consumer {
            made.bsdf = consumer.fitted(made.bsdf, self.kind, &mut made.said)?;
        }
        Ok(made)
    }

    /// The sun's energy by the bands of a spectrum that was measured that far, for programs that read it.
    fn solar(&self, subject: Subject<'_>, watch: &Watch<'_>) -> Result<Option<Band>> {
        let Subject::Continuous(interpolant) = subject else { return Ok(None) };
        let band = Band::new(SOLAR, Vec::new());
        let wanted = self.view.is_none() && self.consumer.is_some_and(|c| c.wants(&band));
        let Some(seen) = interpolant.seen_as(View::Solar).ok().filter(|_| wanted) else {
            return Ok(None);
        };
        // A band has its peaks in cells.
        let made = self.visible(Subject::Continuous(&seen), watch)?.bsdf.with_peaks_in_cells()?;
        Ok(Some(Band { components: made.components().to_vec(), ..band }))
    }

    /// The visible band.
    fn visible(&self, subject: Subject<'_>, watch: &Watch<'_>) -> Result<Delivered> {
        let (mut components, mut reports) = (Vec::new(), Vec::new());
        let mut keep = |made: Tabulated| {
            reports.push(made.report);
            components.push(made.component);
        };
        let mut explicit = Lambertian::default();
        let mut turned = Vec::new();
        match subject {
            Subject::Stored(bsdf) => {
                let peaks = bsdf.specular().iter().map(Specular::is_isotropic);
                let all = bsdf.components().iter().map(tabulate::is_isotropic);
                let rank = common_rank(all.chain(peaks));
                for component in bsdf.components() {
                    let sides = (component.incident, component.scattered);
                    let all = bsdf.components().iter().map(|c| (c.incident, c.scattered));
                    let form = self.form(rank, sides, all.clone());
                    keep(tabulate::stored(component, &form, watch)?);
                    if self.wants_both_ways(rank, sides, all) {
                        turned.push(name_of_sides(sides.1, sides.0));
                        keep(tabulate::stored_reversed(component, &form, watch)?);
                    }
                }
                explicit = *bsdf.explicit_lambertian();
            }
            Subject::Continuous(interpolant) => {
                let peaks = interpolant.specular.iter().map(Specular::is_isotropic);
                let rank =
                    common_rank(interpolant.components.iter().map(Source::isotropic).chain(peaks));
                for part in &interpolant.components {
                    let sides = (part.incident(), part.scattered());
                    let all = interpolant.components.iter().map(|p| (p.incident(), p.scattered()));
                    let form = self.form(rank, sides, all.clone());
                    let made = tabulate::component(part, &form, watch)?;
                    if self.wants_both_ways(rank, sides, all) {
                        turned.push(name_of_sides(sides.1, sides.0));
                        keep(tabulate::reversed(part, &made.component, &form, watch)?);
                    }
                    keep(made);
                }
            }
        }
        let mut loses_colour = false;
        if let Subject::Stored(bsdf) = subject {
            let coloured = |c: &Component| c.distribution().is_coloured();
            let mut pairs = bsdf.components().iter().zip(&components);
            loses_colour = pairs.any(|(old, new)| coloured(old) && !coloured(new));
        }
        let mut peaks = match subject {
            Subject::Stored(bsdf) => bsdf.specular().to_vec(),
            Subject::Continuous(interpolant) => interpolant.specular.clone(),
        };
        let mut said = Vec::new();
        if !turned.is_empty() {
            peaks = both_ways(&peaks);
            said.push(format!("{} not known: the other direction reversed", turned.join(", ")));
        }
        let bsdf = Bsdf::new(Metadata::default(), components, explicit).with_specular(peaks);
        let bands = match subject {
            Subject::Stored(stored) => stored.wavelengths(),
            Subject::Continuous(_) => None, // Which has them still.
        };
        if let (Some(bands), None) = (bands, bsdf.wavelengths()) {
            let count = bands.count();
            said.push(format!(
                "spectra of {count} wavelengths left out: luminance and colour stay"
            ));
        }
        Ok(Delivered { bsdf, reports, loses_colour, said })
    }

    /// Whether the transmission between `sides` needs the other way beside it: Radiance sends no light against the way of a
    /// lone isotropic tree.
    fn wants_both_ways(
        &self,
        rank: Rank,
        sides: (Side, Side),
        all: impl Iterator<Item = (Side, Side)>,
    ) -> bool {
        let trees = self.consumer == Some(Consumer::Radiance) && self.kind == Kind::TensorTree;
        trees && rank == Rank::Three && is_lone(sides, all)
    }

    /// The form of a component between `sides`, beside those between `all`.
    fn form(
        &self,
        rank: Rank,
        sides: (Side, Side),
        all: impl Iterator<Item = (Side, Side)>,
    ) -> Form {
        let reflects = sides.0 == sides.1;
        // Only reflection has both directions in one component.
        let reciprocity = match self.reciprocity {
            Reciprocity::On if !reflects => Reciprocity::Off,
            asked => asked,
        };
        if let Some(basis) = self.kind.basis() {
            let reciprocal = reciprocity == Reciprocity::On;
            let usual = KlemsSettings::default();
            let tolerance = self.max_error.unwrap_or(usual.tolerance);
            return Form::Klems(basis, KlemsSettings { tolerance, reciprocal });
        }
        if self.kind == Kind::Render {
            let usual = RenderSettings::default();
            let max_error = self.max_error.unwrap_or(usual.max_error);
            let reverse = is_lone(sides, all);
            return Form::Render(RenderSettings { max_error, reverse, ..usual });
        }
        let usual = TreeSettings::default();
        Form::Tree(TreeSettings {
            rank: Some(rank),
            max_error: self.max_error.unwrap_or(usual.max_error),
            max_leaves: self
                .max_leaves
                .or(self.max_error.map(|_| TreeSettings::MOST_LEAVES))
                .or(usual.max_leaves),
            max_depth: self.max_depth.or(usual.max_depth),
            reciprocity,
            bands: self.bands,
            ..usual
        })
    }
}

/// Whether this is a transmission, and the other way is not among `all`.
fn is_lone((from, to): (Side, Side), mut all: impl Iterator<Item = (Side, Side)>) -> bool {
    from != to && !all.any(|other| other == (to, from))
}

/// One file holds trees of one rank.
fn common_rank(mut isotropic: impl Iterator<Item = bool>) -> Rank {
    if isotropic.all(|isotropic| isotropic) { Rank::Three } else { Rank::Four }
}
