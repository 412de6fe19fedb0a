//! From a measurement to its interpolant: choose the motion, fit every incidence, plan.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use bsdfkit::{DVec2, DVec3, Result};
use rayon::prelude::*;

use crate::cache::{Cache, KeptIncidence, Stage};
use crate::interpolant::choose::{detector_shadow, select};
use crate::interpolant::component::component::Component;
use crate::interpolant::component::fitted::Fitted;
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::incidence::hues::Hues;
use crate::interpolant::motion::hypothesis::Motion;
use crate::lobe::LobeSet;
use crate::lobe::detail::Detail;
use crate::lobe::fit::{FitOptions, fit};
use crate::lobe::leaves::{Leaf, bin};
use crate::specular::Signature;
use bsdfkit_measure::frame::Frame;
use bsdfkit_measure::{Colorimetry, Image, Incidence, Measurement, Seen, Symmetry};
use bsdfkit_represent::Watch;

/// How an interpolant is made.
#[derive(Clone, Debug)]
pub struct FitSettings {
    /// The frame of transport; `None`: chosen, as all else of the [`Motion`], by leaving incidences
    /// out.
    pub frame: Option<Frame>,
    /// The lobe fit.
    pub lobes: FitOptions,
    /// Least lattice cells across the hemisphere of the finest detail, which has 6 times a power of two: 192 is 0.8
    /// degrees at the normal. With 128, L1 of a real engineered diffuser's fit is two fifths larger.
    pub detail_cells: usize,
    /// Where finished stages are kept; nothing that is made depends on it.
    pub cache: Option<Arc<Cache>>,
    /// How the instrument shows a peak of no width: such peaks are then separated. `None`: none is.
    pub signature: Option<Signature>,
}

impl Default for FitSettings {
    fn default() -> Self {
        let lobes = FitOptions::default();
        Self { frame: None, lobes, detail_cells: 192, cache: None, signature: None }
    }
}

/// ε as a share of the mean BSDF: what is darker than that is reproduced absolutely, not in
/// proportion. Doubling it blurs the darkest parts.
const DARK: f64 = 3e-3;

/// Builds the interpolant of one measured component.
///
/// However few points there are: [`Measurement::expect_enough`] says whether they tell anything.
///
/// Errors: format where incidences cannot be meshed; limit when cancelled.
pub fn build(m: &Measurement, settings: &FitSettings, watch: &Watch<'_>) -> Result<Component> {
    let (guide, hues) = guided(Cow::Borrowed(m));
    build_guided(&guide, hues, settings, watch)
}

/// What steers the fit of `m`, and what its bands add, if it has any. Bands that are owned go.
pub(crate) fn guided(m: Cow<'_, Measurement>) -> (Cow<'_, Measurement>, Option<Hues>) {
    let Some(hues) = Hues::of(&m, DARK * mean_value(&m)) else { return (m, None) };
    let guide = m.guide().into_owned();
    (Cow::Owned(guide), Some(hues))
}

/// [`build`], of what steers it and what bands add.
pub(crate) fn build_guided(
    guide: &Measurement,
    hues: Option<Hues>,
    settings: &FitSettings,
    watch: &Watch<'_>,
) -> Result<Component> {
    let motion = select::motion(guide, settings, watch)?;
    let fitted = fit_all(guide, motion.frame, settings, watch)?;
    let incidences = refitted(&fitted, guide, motion, settings);
    let fitted = fitted.with(incidences).integrated(motion.frame);
    let fitted = match hues {
        Some(hues) => fitted.with_hues(hues, guide, settings.detail_cells),
        None => fitted,
    };
    Component::new(fitted, motion)
}

/// Incidences whose polar angles differ by less than this are fitted side by side.
const RING_DEGREES: f64 = 4.0;

/// Fits all incidences, from the normal outward: each ring starts from the lobes of its nearest
/// neighbours nearer the normal, where less of the distribution is cut by the horizon. Lobes of
/// neighbours then also correspond where nothing was measured.
pub(crate) fn fit_all(
    m: &Measurement,
    frame: Frame,
    settings: &FitSettings,
    watch: &Watch<'_>,
) -> Result<Fitted> {
    let epsilon = DARK * mean_value(m);
    let polar = |k: usize| m.incidences[k].wi.z.abs().clamp(0.0, 1.0).acos().to_degrees();
    let mut order: Vec<usize> = (0..m.incidences.len()).collect();
    order.sort_by(|&a, &b| polar(a).total_cmp(&polar(b)));
    let mut fitted: Vec<Option<(FittedIncidence, LobeSet)>> = vec![None; order.len()];
    let count = AtomicUsize::new(0);
    let stage = Stage::of("incidences", m, settings, &frame);
    for ring in order.chunk_by(|&a, &b| polar(b) - polar(a) < RING_DEGREES) {
        watch.check()?;
        let done: Vec<(usize, (FittedIncidence, LobeSet))> = ring
            .par_iter()
            .map(|&k| {
                let kept = stage.result(k, || {
                    let i = m.incidences[k].with_images(m.symmetry);
                    let start = nearest(&fitted, front(i.wi), m);
                    let fit = fit_incidence(&i, m, frame, epsilon, start.as_ref(), settings);
                    KeptIncidence::of(&fit.0, &fit.1)
                });
                let mut fit = kept.back();
                fit.0.points = m.incidences[k].wo.len();
                watch.finished(&count, order.len());
                (k, fit)
            })
            .collect();
        for (k, f) in done {
            fitted[k] = Some(f);
        }
    }
    let incidences = fitted.into_iter().flatten().map(|(incidence, _)| incidence).collect();
    Ok(Fitted::to(m, epsilon, incidences))
}

/// The same, but those incidences fitted once more of which the neighbours show what the detector could not see.
fn refitted(
    fitted: &Fitted,
    m: &Measurement,
    motion: Motion,
    settings: &FitSettings,
) -> Vec<FittedIncidence> {
    let epsilon = fitted.epsilon;
    let stage = Stage::of("filled in", m, settings, &motion);
    let again = |(k, own): (usize, &FittedIncidence)| {
        let filled = stage.result(k, || {
            let whole = detector_shadow::filled(m, motion, fitted, k)?;
            let whole = whole.with_images(m.symmetry);
            let start = Some(&own.lobes);
            let (fit, lobes) = fit_incidence(&whole, m, motion.frame, epsilon, start, settings);
            Some(KeptIncidence::of(&fit, &lobes))
        });
        match filled {
            Some(kept) => FittedIncidence { points: own.points, ..kept.back().0 },
            None => own.clone(),
        }
    };
    fitted.incidences.par_iter().enumerate().map(again).collect()
}

/// Mean luminance BSDF over all points.
fn mean_value(m: &Measurement) -> f64 {
    let y = m.colorimetry.luminance_channel();
    let (mut sum, mut n) = (0.0, 0usize);
    for i in &m.incidences {
        for v in i.channel(y) {
            sum += v.max(0.0);
            n += 1;
        }
    }
    (sum / n.max(1) as f64).max(1e-9)
}

/// Chords this much apart are alike.
const AS_NEAR: f64 = 1e-6;

/// The lobes, before they were made symmetric, of the fitted incidence nearest to `wi`, as seen
/// through the symmetry that brings it nearest; of those alike near, the one with most light.
fn nearest(
    fitted: &[Option<(FittedIncidence, LobeSet)>],
    wi: DVec3,
    m: &Measurement,
) -> Option<LobeSet> {
    let images = |f: &FittedIncidence| -> Vec<Image> {
        if m.symmetry == Symmetry::Isotropic {
            let (to, from) = (Image::rotation_to(wi), Image::rotation_to(f.wi).inverse());
            let after = |v: DVec2| to.x * v.x + to.y * v.y;
            vec![Image { x: after(from.x), y: after(from.y) }]
        } else {
            m.symmetry.images().to_vec()
        }
    };
    let seen = fitted.iter().flatten().flat_map(|(f, lobes)| {
        images(f).into_iter().map(move |i| (i.apply(f.wi).distance(wi), f.hemispherical, lobes, i))
    });
    let (_, _, lobes, image) = seen.min_by(|a, b| {
        let alike = (a.0 - b.0).abs() < AS_NEAR;
        if alike { b.1.total_cmp(&a.1) } else { a.0.total_cmp(&b.0) }
    })?;
    Some(lobes.transformed(image.x, image.y))
}

fn front(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, w.z.abs())
}

/// Fits `seen`, the points of an incidence with their images; where they are on one plane, also what that lets
/// expect beside it.
fn fit_incidence(
    seen: &Incidence,
    m: &Measurement,
    frame: Frame,
    epsilon: f64,
    start: Option<&LobeSet>,
    settings: &FitSettings,
) -> (FittedIncidence, LobeSet) {
    let wi = front(seen.wi);
    let (channels, y) = (m.colorimetry.channels(), m.colorimetry.luminance_channel());
    // Peaks are as wide beside a plane as on it: on the sphere, or in slopes of facets; not on the disk, which foreshortens them.
    let round = match frame {
        Frame::Half | Frame::Refracted { .. } => frame,
        _ => Frame::Turned,
    };
    let i = seen.extended(y, round);
    let leaves = bin(i.points(y));
    let at = frame.at(wi);
    let fitted = fit(&leaves, &at, start, &settings.lobes);
    let lobes = m
        .symmetry
        .keeping(wi)
        .fold(fitted.clone(), |lobes, image| lobes.symmetrised(image.x, image.y));
    let of = |u: DVec2| lobes.floor + lobes.density(at.forward(u)) / at.density(u) + epsilon;
    let model: Vec<f32> = i.wo.iter().map(|w| of(w.truncate()) as f32).collect();
    let detail = |channel: usize| {
        let shares = model.iter().zip(i.channel(channel));
        let share = |(m, v): (&f32, f64)| ((v.max(0.0) + epsilon) / f64::from(*m)) as f32;
        let ratio: Vec<f32> = shares.map(share).collect();
        // What is bright counts more: an error of a share is an error of so much light.
        Detail::fit(i.wo.iter(), &ratio, &model, settings.detail_cells)
    };
    let mut details = vec![detail(y)];
    if m.colorimetry == Colorimetry::Xyz {
        details.extend((0..channels).filter(|&c| c != y).map(detail));
    }
    let fit = |w: DVec3, m: f32| {
        (f64::from(m) * details[0].log_at(w.truncate()).exp() - epsilon).max(0.0)
    };
    let sum = |leaves: &[Leaf]| {
        leaves.iter().filter(|l| l.count > 0).map(|l| l.value * l.area).sum::<f64>()
    };
    let own = seen.wo.len();
    let misfit = i.points(y).zip(&model).take(own).map(|((w, v), &m)| (w, (fit(w, m) - v).abs()));
    let misfit = sum(&bin(misfit));
    let all = sum(&leaves);
    let measured = if own < i.wo.len() { sum(&bin(seen.points(y))) } else { all };
    let incidence = FittedIncidence {
        wi,
        lobes,
        details,
        coefficients: Vec::new(),
        points: i.wo.len(),
        hemispherical: all,
        fit_error: misfit / measured.max(1e-12),
        limit: i.wo.iter().map(|w| w.truncate().length()).fold(0.0, f64::max),
        seen: Seen::of(seen),
    };
    (incidence, fitted)
}
