//! The peaks of a component followed over all incident directions: where each is, and what of f is its own.

use bsdfkit::render::Chart;
use bsdfkit::{DVec2, DVec3};

use crate::interpolant::answer::distribution::Distribution;
use crate::interpolant::component::component::Component;
use crate::interpolant::facet::refracted_lobe::visible;
use crate::interpolant::family::assign::turned;
use crate::interpolant::family::tracks::{Item, lone, tracks};
use crate::lobe::{Covariance, Lobe};
use bsdfkit_measure::frame::{Frame, FrameAt};
use bsdfkit_represent::{Extent, Followed};

/// Most peaks that are told apart.
const MOST: usize = 8;

/// A peak has at least so much of the light of all incidences together.
const LEAST: f64 = 0.01;

/// What moves in one way: the lobes of a law, or of a facet.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Law(u8),
    Facet(u8),
}

/// A peak: its middle at every node of the chart, in the coordinates of its way.
struct Track {
    way: Way,
    middles: Vec<DVec2>,
    covariances: Vec<Covariance>,
    mass: f64,
}

/// The peaks of a component.
pub(crate) struct FollowedPeaks<'a> {
    component: &'a Component,
    chart: Chart,
    /// The frame of all others first.
    laws: Vec<Frame>,
    tracks: Vec<Track>,
}

/// A lobe at an incident direction, in coordinates of its law there.
struct Here {
    way: Way,
    lobe: Lobe,
    frame: FrameAt,
}

/// The lobes of an incident direction.
fn here(at: &Distribution<'_>) -> Vec<Here> {
    let way = |facet: Option<u8>| facet.map_or(Way::Law(0), Way::Facet);
    let moved = at.moved.iter();
    let mut all: Vec<Here> =
        moved.map(|m| Here { way: way(m.facet), lobe: m.lobe, frame: at.frame }).collect();
    for (c, corner) in at.corners.iter().enumerate().filter(|(_, c)| c.weight > 0.0) {
        for ((number, law), lobes) in (1_u8..).zip(&at.laws).zip(corner.families) {
            for lobe in lobes.iter().map(|standing| &standing.lobe) {
                let Some(there) = turned(lobe, corner.frame, law.there[c]) else { continue };
                let mass = law.per_seen * corner.weight * lobe.mass;
                let lobe = Lobe { mass, ..there };
                all.push(Here { way: Way::Law(number), lobe, frame: law.here });
            }
        }
    }
    // What has no extent has no light.
    all.retain(|h| h.lobe.covariance.determinant() > 1e-18 && h.lobe.mean.is_finite());
    all
}

fn item(here: &Here, all: f64) -> Item {
    Item {
        mean: here.lobe.mean,
        width: here.lobe.covariance.determinant().max(1e-18).sqrt().sqrt(),
        mass: here.lobe.mass * visible(&here.lobe, &here.frame) / all.max(1e-300),
    }
}

impl<'a> FollowedPeaks<'a> {
    /// Those of a component, followed over a chart.
    pub(crate) fn of(component: &'a Component, chart: &Chart) -> Self {
        let motion = &component.motion();
        let laws: Vec<Frame> = std::iter::once(motion.frame).chain(motion.laws()).collect();
        // Off the mirrors, so that all are in the frame that incident directions are folded into: the chart's.
        let aside = DVec3::new(1e-9, 1e-9, 0.0);
        let wi: Vec<DVec3> = (0..chart.nodes()).map(|n| chart.direction(n) + aside).collect();
        let nodes: Vec<Vec<Here>> = wi.iter().map(|&w| here(&component.at(w))).collect();
        let mut ways: Vec<Way> = Vec::new();
        nodes.iter().flatten().for_each(|h| {
            if !ways.contains(&h.way) {
                ways.push(h.way);
            }
        });
        let mut found = Vec::new();
        for way in ways {
            let items: Vec<Vec<Item>> = nodes
                .iter()
                .map(|lobes| {
                    let all: f64 = lobes.iter().map(|h| h.lobe.mass).sum();
                    lobes.iter().filter(|h| h.way == way).map(|h| item(h, all)).collect()
                })
                .collect();
            let apart = |a: usize, b: usize| wi[a].distance_squared(wi[b]);
            let all = match way {
                Way::Law(_) => tracks(&items, apart, MOST),
                Way::Facet(_) => vec![lone(&items, apart)],
            };
            let mut mass = vec![0.0; all.len()];
            for (n, items) in items.iter().enumerate() {
                for i in items {
                    let off = |k: &usize| all[*k][n].distance_squared(i.mean);
                    let near = (0..all.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
                    near.iter().for_each(|&k| mass[k] += i.mass / nodes.len() as f64);
                }
            }
            for (middles, mass) in all.into_iter().zip(mass) {
                let covariances = shapes(way, &middles, &nodes, &items);
                found.push(Track { way, middles, covariances, mass });
            }
        }
        found.sort_by(|a, b| b.mass.total_cmp(&a.mass));
        // The first stays, whatever it is; what has hardly any light goes with others.
        let mut first = true;
        found.retain(|t| std::mem::take(&mut first) || t.mass > LEAST);
        found.truncate(MOST);
        Self { component, chart: *chart, laws, tracks: found }
    }

    fn frame(&self, way: Way, wi: DVec3) -> FrameAt {
        let law = match way {
            Way::Law(number) => self.laws[usize::from(number)],
            Way::Facet(_) => self.laws[0],
        };
        law.at(wi)
    }

    /// The middles of all peaks at a folded incident direction, in coordinates of their ways.
    fn middles(&self, folded: DVec3) -> Vec<DVec2> {
        let blend = self.chart.blend(folded);
        let of = |t: &Track| blend.iter().map(|&(n, w)| w * t.middles[n]).sum();
        self.tracks.iter().map(of).collect()
    }
}

/// The covariance of a peak at every node: by lobes that tell where it is. Laws keep it; what facets do changes it.
fn shapes(
    way: Way,
    middles: &[DVec2],
    nodes: &[Vec<Here>],
    items: &[Vec<Item>],
) -> Vec<Covariance> {
    let (mut each, mut mean, mut count) = (Vec::new(), Covariance::isotropic(0.0), 0.0);
    for ((&middle, lobes), items) in middles.iter().zip(nodes).zip(items) {
        let (mut sum, mut weight) = (Covariance::isotropic(0.0), 0.0);
        for (here, item) in lobes.iter().filter(|h| h.way == way).zip(items) {
            let w = item.tells(middle);
            sum = Covariance::combine(1.0, sum, w, here.lobe.covariance);
            weight += w;
        }
        let own = (weight > 1e-9)
            .then(|| Covariance::combine(1.0 / weight, sum, 0.0, Covariance::isotropic(0.0)));
        if let Some(own) = own {
            (mean, count) = (Covariance::combine(1.0, mean, 1.0, own), count + 1.0);
        }
        each.push(own);
    }
    let mean = match count > 0.0 {
        true => Covariance::combine(1.0 / count, mean, 0.0, Covariance::isotropic(0.0)),
        false => Covariance::isotropic(0.01),
    };
    let of = |own: Option<Covariance>| match way {
        Way::Law(_) => mean,
        Way::Facet(_) => own.unwrap_or(mean),
    };
    each.into_iter().map(of).collect()
}

/// Deviations beyond which a lobe is not looked at: it has less than 1e-8 of its height there.
const TAIL: f64 = 200.0;

/// The square of the distance of a lobe from a middle within which it is that peak's alone.
const OWN: f64 = 1e-4;

impl Followed for FollowedPeaks<'_> {
    fn count(&self) -> usize {
        self.tracks.len().max(1)
    }

    fn extents(&self, wi: DVec3) -> Vec<Option<Extent>> {
        let (folded, fold) = self.component.symmetry().fold(DVec3::new(wi.x, wi.y, wi.z.abs()));
        let back = fold.inverse();
        let blend = self.chart.blend(folded);
        let disk = Frame::Fixed.at(folded);
        let extent = |t: &Track| {
            let frame = self.frame(t.way, folded);
            let mean: DVec2 = blend.iter().map(|&(n, w)| w * t.middles[n]).sum();
            let mut covariance = Covariance::isotropic(0.0);
            for &(n, w) in &blend {
                covariance = Covariance::combine(1.0, covariance, w, t.covariances[n]);
            }
            let lobe = turned(&Lobe { mass: 1.0, mean, covariance }, &frame, &disk)?;
            let lobe = lobe.transformed(back.x, back.y);
            let c = lobe.covariance;
            Some(Extent { centre: lobe.mean, covariance: [c.xx, c.xy, c.yy] })
        };
        if self.tracks.is_empty() {
            return vec![None];
        }
        self.tracks.iter().map(extent).collect()
    }

    /// By the height of lobes with wings: shares change slowly where f is dim. A lobe belongs to the peaks near it.
    fn shares(&self, wi: DVec3, wo: &[DVec3], out: &mut [f32]) {
        let at = self.component.at(wi);
        let folded = at.fold().apply(DVec3::new(wi.x, wi.y, wi.z.abs()));
        let middles = self.middles(folded);
        let count = self.count();
        let all: Vec<_> = here(&at)
            .into_iter()
            .map(|h| {
                let mut of = vec![0.0; count];
                for ((of, track), middle) in of.iter_mut().zip(&self.tracks).zip(&middles) {
                    if track.way == h.way {
                        let off = middle.distance_squared(h.lobe.mean) + OWN;
                        *of = 1.0 / (off * off);
                    }
                }
                let sum: f64 = of.iter().sum();
                match sum > 0.0 {
                    true => of.iter_mut().for_each(|of| *of /= sum),
                    false => of[0] = 1.0,
                }
                let det = h.lobe.covariance.determinant().max(1e-18);
                let height = h.lobe.mass / (std::f64::consts::TAU * det.sqrt());
                (h.frame, h.lobe.mean, h.lobe.covariance.inverse(), height, of)
            })
            .collect();
        let mut sums = vec![0.0; count];
        for (wo, out) in wo.iter().zip(out.chunks_exact_mut(count)) {
            let u = at.fold().apply(*wo).truncate().clamp_length_max(0.999_99);
            sums.fill(0.0);
            sums[0] = at.floor + 1e-12;
            for (frame, mean, precision, height, of) in &all {
                let e = precision.quadratic(frame.forward(u) - *mean);
                if e < TAIL * TAIL {
                    let wing = 1.0 / (1.0 + 0.5 * e);
                    let value = height * wing * wing / frame.density(u);
                    sums.iter_mut().zip(of).for_each(|(sum, of)| *sum += of * value);
                }
            }
            let whole: f64 = sums.iter().sum();
            for (out, sum) in out.iter_mut().zip(&sums) {
                *out = (sum / whole) as f32;
            }
        }
    }
}
