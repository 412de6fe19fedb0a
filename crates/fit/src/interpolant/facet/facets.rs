//! Peaks that follow a facet from incidence to incidence.
//!
//! Each peak of transmitted light is asked whether it goes, over all measured incidences, where and as
//! bright as some [`Facet`] would have it. One that does is carried by the facet between incidences and
//! past the last of them. What the facet does not explain of energy, place and shape is
//! interpolated as ever, and other peaks are left alone.

use bsdfkit::{DVec2, DVec3};

use crate::interpolant::facet::facet::{Facet, NEAR, Passed, Seen};
use crate::interpolant::facet::refracted_lobe::{Carried, Place, Shape, direction};
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::interpolant::motion::edge_plan::EdgePlan;
use crate::interpolant::motion::moved::Moved;
use crate::lobe::frame::Frame;
use crate::lobe::{Covariance, Lobe, LobeSet};

/// The facets of a component, and the lobes that follow them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Facets {
    facets: Vec<Followed>,
    /// Of each vertex and lobe: its facet.
    of: Vec<Vec<Option<u8>>>,
}

/// A facet that peaks follow.
#[derive(Clone, Debug)]
struct Followed {
    facet: Facet,
    shape: Shape,
    /// Of each vertex: how much it has to say of the peak elsewhere.
    say: Vec<f64>,
}

/// Indices tried first: from water to heavy glass. The refinement bridges the gaps.
const INDICES: [f64; 5] = [1.35, 1.45, 1.55, 1.65, 1.8];
/// A facet's normal leans at least so far (3 degrees): what is not refracted ends nowhere.
const TILTED: f64 = 0.05;
/// Root of the mean square distance between a facet's peaks and the measured ones, at most: half a
/// degree.
const PLACED: f64 = 0.01;
/// Peaks have no say in a facet that are so many times as far from where it has them as half of them are, ...
const OUTLYING: f64 = 4.0;
/// ... and not close even so: two that run into one another, or that the horizon cuts.
const CLOSE: f64 = 0.005;
/// Peaks below this share of their incidence's energy are not looked at.
const SEEN: f64 = 0.03;
/// Incidences that show a facet's peak, at least: of three numbers each, more than four times its
/// unknowns.
const HITS: usize = 6;
/// One in so many may miss it, where few show it two: with one in ten and nine hits a facet was lost to one
/// incidence close to where it reflects, and L1 went from 0.024 to 0.08.
const MISSED: usize = 6;
/// Peaks from which facets are guessed, at most.
const SEEDS: usize = 60;
/// A lobe that covers so many times as much as a peak is no part of it. A guess.
const WIDE: f64 = 3.0;
/// Facets looked for, at most: a guess, structures have two or three.
const MOST: usize = 8;

impl Facets {
    /// Looks for facets that explain the peaks of the vertices. `energy`: directional-hemispherical
    /// values there.
    ///
    /// Cost: about 0.1 ms a vertex and facet.
    pub(crate) fn of(
        mesh: &IncidenceMesh,
        lobes: &[LobeSet],
        energy: &[f64],
        frame: Frame,
    ) -> Self {
        let mut seen: Vec<Vec<Seen>> = (0..lobes.len())
            .map(|v| peaks_of(v, mesh.vertices[v].wi, &lobes[v], energy[v], frame))
            .collect();
        let mut areas = Vec::new();
        let mut found = Self {
            facets: Vec::new(),
            of: lobes.iter().map(|s| vec![None; s.lobes.len()]).collect(),
        };
        while found.facets.len() < MOST
            && let Some((facet, hits, near)) = next(mesh, &seen)
        {
            let mut say = vec![1.0; lobes.len()];
            let mut extents = Vec::new();
            for Seen { vertex, lobes: of, passed } in hits {
                let Some(own) = facet.pass(mesh.vertices[vertex].wi) else { continue };
                let off = own.u.distance(passed.u);
                // Where it is not the facet's it is no guide: the horizon cuts it.
                say[vertex] = (near / off.max(near)).powi(2);
                if off <= near {
                    let parts = of.iter().map(|&i| lobes[vertex].lobes[i as usize]);
                    extents.push((own.u, together(parts)));
                }
                for &i in &of {
                    found.of[vertex][i as usize] = Some(found.facets.len() as u8);
                }
                seen[vertex].retain(|s| s.lobes != of);
            }
            let shape = Shape::kept(&extents, frame);
            found.facets.push(Followed { facet, shape, say });
            let area = extents.iter().map(|(_, c)| c.determinant().sqrt()).sum::<f64>();
            areas.push(area / extents.len().max(1) as f64);
        }
        found.adopt(mesh, lobes, &areas, frame);
        found
    }

    /// Lets lobes that are not parts of a peak explained follow the facet whose peak should be where
    /// they are: peaks run into one another, and have wings. `areas`: what each facet's peaks cover.
    fn adopt(&mut self, mesh: &IncidenceMesh, lobes: &[LobeSet], areas: &[f64], frame: Frame) {
        for ((vertex, set), of) in mesh.vertices.iter().zip(lobes).zip(&mut self.of) {
            let at = frame.at(vertex.wi);
            let centres: Vec<Option<DVec2>> =
                self.facets.iter().map(|f| Some(at.forward(f.facet.pass(vertex.wi)?.u))).collect();
            for (lobe, of) in set.lobes.iter().zip(of).filter(|(_, of)| of.is_none()) {
                let precision = lobe.covariance.inverse();
                let off = |k: usize| {
                    let narrow = lobe.covariance.determinant().sqrt() < WIDE * areas[k];
                    let off = precision.quadratic(lobe.mean - centres[k]?);
                    (narrow && off < 9.0).then_some((off, k as u8))
                };
                let nearest = (0..centres.len()).filter_map(off);
                *of = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| k);
            }
        }
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// The plan along the edge `ab` of the mesh of the lobes that follow no facet, as `reach` has it.
    pub(crate) fn plan(&self, lobes: &[LobeSet], [a, b]: [u32; 2], reach: f64) -> EdgePlan {
        let free = |v: u32| -> (Vec<u16>, LobeSet) {
            let set = &lobes[v as usize];
            let index = (0..set.lobes.len() as u16).filter(|&i| !self.rules(v, i));
            let index: Vec<u16> = index.collect();
            let lobes = index.iter().map(|&i| set.lobes[i as usize]).collect();
            (index, LobeSet { floor: set.floor, lobes })
        };
        let ((from, at_a), (to, at_b)) = (free(a), free(b));
        let mut plan = EdgePlan::between(&at_a, &at_b, reach);
        for pair in &mut plan.pairs {
            pair.from = pair.from.map(|i| from[i as usize]);
            pair.to = pair.to.map(|j| to[j as usize]);
        }
        plan
    }

    /// Whether a lobe follows a facet.
    pub(crate) fn rules(&self, vertex: u32, lobe: u16) -> bool {
        let of = self.of.get(vertex as usize).and_then(|of| of.get(lobe as usize));
        of.is_some_and(Option::is_some)
    }

    /// The lobes of a cell that follow facets, at `wi` and weights `lambda` of its corners: each corner's where its facet
    /// carries them, as bright as that has them. They are blended: those of one peak, fitted at two incidences, divide it
    /// in different ways, and between partners that are not alike it would be too narrow half-way.
    pub(crate) fn moved(
        &self,
        (mesh, lobes, frame): (&IncidenceMesh, &[LobeSet], Frame),
        (corners, lambda): ([u32; 3], [f64; 3]),
        wi: DVec3,
    ) -> Vec<Moved> {
        let mut all = Vec::new();
        for (k, Followed { facet, shape, say }) in self.facets.iter().enumerate() {
            let own = |v: u32| {
                let of = lobes[v as usize].lobes.iter().zip(&self.of[v as usize]);
                of.filter(move |(_, of)| **of == Some(k as u8)).map(|(lobe, _)| *lobe)
            };
            let place = |wi: DVec3| {
                let passed = facet.pass(wi)?;
                Some((shape.at(passed.u, &frame.at(wi)), passed.energy))
            };
            let Some((here, energy)) = place(wi) else { continue };
            let corner = |v: usize| {
                let there = lambda[v] > 0.0 && own(corners[v]).next().is_some();
                place(mesh.vertices[corners[v] as usize].wi).filter(|_| there)
            };
            let from = [0, 1, 2].map(corner);
            // Of corners where little is left, which says little, little is made.
            let weight = [0, 1, 2].map(|v| lambda[v] * say[corners[v] as usize]);
            let brightness = [0, 1, 2].map(|v| from[v].map_or(0.0, |f| weight[v] * f.1));
            let whole: f64 = brightness.iter().sum();
            if whole <= 0.0 {
                continue;
            }
            for (v, corner) in from.iter().enumerate() {
                let Some((at, _)) = *corner else { continue };
                let carried = Carried { from: at, to: here };
                let mut shares = [0.0; 3];
                shares[v] = 1.0;
                all.extend(own(corners[v]).map(|lobe| {
                    let mass = weight[v] * lobe.mass * energy / whole;
                    let lobe = carried.lobe(Lobe { mass, ..lobe });
                    // Other corners are asked where the facet has them, or, without it, at the same place.
                    let back = |corner: Option<(Place, f64)>| match corner {
                        Some((to, _)) => {
                            let there = Carried { from: here, to }.lobe(lobe);
                            (there.mean, lobe.covariance.transport_to(there.covariance))
                        }
                        None => (lobe.mean, Covariance::isotropic(1.0)),
                    };
                    let moved = Moved::new(lobe, from.map(back), shares);
                    Moved { facet: Some(k as u8), ..moved }
                }));
            }
        }
        all
    }
}

/// The facet that explains most of what is left, its peaks, and how near to it they are that have a say.
fn next(mesh: &IncidenceMesh, seen: &[Vec<Seen>]) -> Option<(Facet, Vec<Seen>, f64)> {
    let all: Vec<&Seen> = seen.iter().flatten().collect();
    let step = all.len().div_ceil(SEEDS).max(1);
    let guesses = all.iter().step_by(step).flat_map(|s| {
        INDICES.iter().filter_map(|&n| Facet::through(mesh.vertices[s.vertex].wi, s.passed, n))
    });
    let (mut facet, hits, _) = guesses
        .filter(|f| f.leans() > TILTED)
        .map(|f| (f, f.explains(mesh, seen, NEAR)))
        .map(|(f, (hits, missed))| (f, hits.len(), missed))
        .max_by_key(|&(_, hits, missed)| hits as i64 - missed as i64)?;
    if hits < HITS / 2 {
        return None;
    }
    let (mut off, mut near) = (Vec::new(), NEAR);
    for _ in 0..5 {
        let (hits, _) = facet.explains(mesh, seen, near);
        (facet, off) = facet.refined(mesh, &hits);
        let usual = off.get(off.len() / 2).copied().unwrap_or(NEAR);
        near = near.min((OUTLYING * usual).max(CLOSE));
    }
    let off = (off.iter().map(|d| d * d).sum::<f64>() / off.len().max(1) as f64).sqrt();
    let (hits, missed) = facet.explains(mesh, seen, NEAR);
    let holds = hits.len() >= HITS && MISSED * missed <= hits.len().max(2 * MISSED) && off < PLACED;
    let hits = hits.into_iter().cloned().collect();
    (holds && facet.leans() > TILTED).then_some((facet, hits, near))
}

/// The covariance of lobes taken together.
fn together(lobes: impl Iterator<Item = Lobe> + Clone) -> Covariance {
    let mass: f64 = lobes.clone().map(|l| l.mass).sum();
    let mean = lobes.clone().map(|l| l.mass * l.mean).sum::<DVec2>() / mass;
    lobes.fold(Covariance::isotropic(0.0), |sum, l| {
        let (d, c, w) = (l.mean - mean, l.covariance, l.mass / mass);
        let own = Covariance { xx: c.xx + d.x * d.x, xy: c.xy + d.x * d.y, yy: c.yy + d.y * d.y };
        Covariance::combine(1.0, sum, w, own)
    })
}

/// The peaks of a vertex: where they are and their energy.
fn peaks_of(vertex: usize, wi: DVec3, set: &LobeSet, energy: f64, frame: Frame) -> Vec<Seen> {
    let total = set.total() + std::f64::consts::PI * set.floor;
    let at = frame.at(wi);
    let seen = |lobes: Vec<u16>| {
        let of = |i: &u16| set.lobes[*i as usize];
        let mass: f64 = lobes.iter().map(|i| of(i).mass).sum();
        let mean = lobes.iter().map(|i| direction(&of(i), &at)).sum::<DVec3>().normalize_or_zero();
        let passed = Passed { u: mean.truncate(), energy: energy * mass / total.max(1e-300) };
        (mass > SEEN * total && mean.z > 0.0).then_some(Seen { vertex, lobes, passed })
    };
    set.peaks().into_iter().filter_map(seen).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::Symmetry;
    use bsdfkit_sphere::direction::from_degrees;
    use bsdfkit_sphere::locate::Location;

    /// Two facets' peaks, the second of them of two lobes, and one that goes straight through.
    fn scene(second: impl Fn(DVec3, Passed) -> Passed) -> (IncidenceMesh, Vec<LobeSet>, Vec<f64>) {
        let mut wi = vec![DVec3::Z];
        for t in [15.0, 30.0, 45.0, 60.0] {
            wi.extend((0..12).map(|p| from_degrees(t, f64::from(p) * 30.0)));
        }
        let passed = |u: f64, energy: f64| Passed { u: DVec2::new(u, 0.0), energy };
        let facets = [passed(-0.25, 0.4), passed(0.3, 0.3)]
            .map(|p| Facet::through(DVec3::Z, p, 1.5).expect("a facet"));
        let set = |&w: &DVec3| {
            let at = Frame::Shift.at(w);
            let lobe = |mass: f64, u: DVec2, aside: f64| Lobe {
                mass,
                mean: at.forward(u) + DVec2::new(0.0, aside),
                covariance: Covariance::isotropic(4e-4),
            };
            let mut lobes = vec![lobe(0.1, -w.truncate(), 0.0)];
            lobes.extend(facets[0].pass(w).map(|p| lobe(p.energy, p.u, 0.0)));
            if let Some(p) = facets[1].pass(w).map(|p| second(w, p)) {
                lobes.extend([-0.01, 0.01].map(|aside| lobe(0.5 * p.energy, p.u, aside)));
            }
            LobeSet { floor: 0.0, lobes }
        };
        let lobes: Vec<LobeSet> = wi.iter().map(set).collect();
        let energy = lobes.iter().map(LobeSet::total).collect();
        (IncidenceMesh::new(&wi, Symmetry::None).expect("mesh"), lobes, energy)
    }

    fn following(facets: &Facets, lobes: &[LobeSet]) -> [usize; 4] {
        let mut counts = [0; 4];
        for (v, set) in lobes.iter().enumerate() {
            for i in 0..set.lobes.len() {
                counts[i] += usize::from(facets.rules(v as u32, i as u16));
            }
        }
        counts
    }

    #[test]
    fn peaks_of_facets_follow_them_and_what_goes_straight_through_does_not() {
        let (mesh, lobes, energy) = scene(|_, p| p);
        let facets = Facets::of(&mesh, &lobes, &energy, Frame::Shift);
        let all: usize = lobes.iter().map(|set| set.lobes.len() - 1).sum();
        let counts = following(&facets, &lobes);
        assert_eq!((counts[0], counts.iter().sum()), (0, all));
        // What goes straight through is left to plan.
        for &edge in mesh.topology.edges() {
            let plan = facets.plan(&lobes, edge, 0.1);
            assert!(plan.pairs.len() == 1 && plan.pairs[0].from == Some(0), "{plan:?}");
            assert_eq!(plan.pairs[0].to, Some(0));
        }
    }

    #[test]
    fn a_peak_that_moves_or_darkens_otherwise_is_left_alone() {
        let free = |second: &dyn Fn(DVec3, Passed) -> Passed| {
            let (mesh, lobes, energy) = scene(second);
            let counts = following(&Facets::of(&mesh, &lobes, &energy, Frame::Shift), &lobes);
            (counts[1], counts[2] + counts[3])
        };
        let all = free(&|_, p| p);
        // Where a louvre would have it; and darker by far on one side.
        let louvre = |w: DVec3, p: Passed| Passed { u: DVec2::new(0.3, 0.0) - w.truncate(), ..p };
        let shade = |w: DVec3, p: Passed| Passed { energy: p.energy * (5.0 * w.y).exp(), ..p };
        for (first, second) in [free(&louvre), free(&shade)] {
            assert!(second == 0 && first + 20 > all.0, "{first} {second} {all:?}");
        }
    }

    #[test]
    fn an_incidence_whose_peak_is_cut_does_not_mislead_its_neighbours() {
        let (mesh, whole, energy) = scene(|_, p| p);
        // At four incidences, one of them a neighbour, the first peak is out of place and broadened.
        let mut cut = whole.clone();
        let there = [(60.0, 120.0), (60.0, 240.0), (60.0, 180.0), (45.0, 180.0)];
        let there = there.map(|(theta, phi)| from_degrees(theta, phi));
        for (v, set) in mesh.vertices.iter().zip(&mut cut) {
            if there.iter().any(|w| w.distance(v.wi) < 1e-9) {
                let lobe = &mut set.lobes[1];
                lobe.mean += DVec2::new(0.015, 0.015);
                lobe.covariance = Covariance::combine(6.0, lobe.covariance, 0.0, lobe.covariance);
            }
        }
        let wi = from_degrees(55.0, 125.0);
        let passed = Passed { u: DVec2::new(-0.25, 0.0), energy: 0.4 };
        let facet = Facet::through(DVec3::Z, passed, 1.5).expect("a facet");
        let place = Frame::Shift.at(wi).forward(facet.pass(wi).expect("passes").u);
        let of = |lobes: &[LobeSet]| {
            let facets = Facets::of(&mesh, lobes, &energy, Frame::Shift);
            let Location::Inside { triangle, barycentric } = mesh.locate(wi) else {
                panic!("inside the mesh")
            };
            let corners = mesh.topology.triangles()[triangle as usize];
            assert!(
                corners.iter().any(|&v| lobes[v as usize] != whole[v as usize]) || lobes == whole
            );
            let moved = facets.moved((&mesh, lobes, Frame::Shift), (corners, barycentric), wi);
            let first = moved.iter().map(|m| m.lobe).filter(|l| l.mean.distance(place) < 0.05);
            let mass: f64 = first.clone().map(|l| l.mass).sum();
            (together(first.clone()), first.map(|l| l.mass * l.mean).sum::<DVec2>() / mass, mass)
        };
        let (truth, misled) = (of(&whole), of(&cut));
        let broader = (misled.0.determinant() / truth.0.determinant()).sqrt();
        assert!(broader < 2.5, "{broader}");
        assert!(misled.1.distance(truth.1) < 0.005, "{} {}", misled.1, truth.1);
        assert!((misled.2 / truth.2 - 1.0).abs() < 0.01, "{} {}", misled.2, truth.2);
    }

    #[test]
    fn peaks_that_have_run_into_brighter_ones_are_not_missed() {
        let (mesh, mut lobes, energy) = scene(|_, p| p);
        let all = following(&Facets::of(&mesh, &lobes, &energy, Frame::Shift), &lobes);
        // The two lobes of the second peak are one of three times the energy, 0.1 aside.
        let mut merged = 0;
        for set in lobes.iter_mut().skip(1).step_by(3).filter(|set| set.lobes.len() == 4) {
            let lobe = set.lobes[2];
            let mean = lobe.mean + DVec2::new(0.1, 0.0);
            set.lobes.splice(2.., [Lobe { mass: 6.0 * lobe.mass, mean, ..lobe }]);
            merged += 1;
        }
        let facets = Facets::of(&mesh, &lobes, &energy, Frame::Shift);
        let counts = following(&facets, &lobes);
        assert!(6 * merged > all[3], "{merged} {all:?}");
        assert!(facets.facets.len() == 2 && counts[3] + merged == all[3], "{counts:?} {all:?}");
    }

    /// Brightness and second moments of what follows facets at `wi`, from the triangle about it.
    fn moved(
        (mesh, lobes): (&IncidenceMesh, &[LobeSet]),
        facets: &Facets,
        wi: DVec3,
        facet: usize,
    ) -> (f64, Covariance) {
        let Location::Inside { triangle, barycentric } = mesh.locate(wi) else { panic!("outside") };
        let corners = mesh.topology.triangles()[triangle as usize];
        let all = facets.moved((mesh, lobes, Frame::Shift), (corners, barycentric), wi);
        let at = Frame::Shift.at(wi);
        let near = facets.facets[facet].facet.pass(wi).map(|p| at.forward(p.u));
        let here =
            all.iter().map(|m| m.lobe).filter(|l| near.is_some_and(|c| l.mean.distance(c) < 0.03));
        (here.clone().map(|l| l.mass).sum(), together(here))
    }

    #[test]
    fn carried_lobes_are_as_bright_as_the_facet_has_them_and_end_where_it_reflects() {
        let (mesh, lobes, energy) = scene(|_, p| p);
        let facets = Facets::of(&mesh, &lobes, &energy, Frame::Shift);
        let second = usize::from(facets.facets[0].facet.pass(DVec3::Z).expect("passes").u.x < 0.0);
        let bright = |degrees: f64| {
            let wi = from_degrees(degrees, 180.0);
            let has = facets.facets[second].facet.pass(wi).map_or(0.0, |p| p.energy);
            (moved((&mesh, &lobes), &facets, wi, second).0, has)
        };
        // This facet leans 34 degrees: light that comes from −x ends beyond 12.
        for degrees in [0.0, 2.0, 5.0, 10.0] {
            let (found, has) = bright(degrees);
            assert!((found / has - 1.0).abs() < 5e-3, "{degrees}: {found} {has}");
        }
        assert_eq!(bright(20.0).0, 0.0);
    }

    #[test]
    fn a_peak_divided_in_different_ways_stays_as_wide() {
        let (mesh, mut lobes, energy) = scene(|_, p| p);
        // Every other incidence has the two lobes of the second peak beside instead of above each other.
        for set in lobes.iter_mut().skip(1).step_by(2).filter(|set| set.lobes.len() == 4) {
            let middle = 0.5 * (set.lobes[2].mean + set.lobes[3].mean);
            set.lobes[2].mean = middle - DVec2::new(0.01, 0.0);
            set.lobes[3].mean = middle + DVec2::new(0.01, 0.0);
        }
        let facets = Facets::of(&mesh, &lobes, &energy, Frame::Shift);
        let second = usize::from(facets.facets[0].facet.pass(DVec3::Z).expect("passes").u.x < 0.0);
        for wi in [from_degrees(20.0, 10.0), from_degrees(38.0, 50.0), from_degrees(50.0, 340.0)] {
            let trace = moved((&mesh, &lobes), &facets, wi, second).1.trace();
            assert!((trace / (8e-4 + 1e-4) - 1.0).abs() < 0.02, "{wi}: {trace}");
        }
    }

    #[test]
    fn dark_incidences_leave_no_holes_in_numbers() {
        let (mesh, mut lobes, mut energy) = scene(|_, p| p);
        for v in (0..lobes.len()).step_by(3) {
            lobes[v].lobes.iter_mut().for_each(|l| l.mass = 0.0);
            energy[v] = 0.0;
        }
        energy[4] = f64::NAN;
        let facets = Facets::of(&mesh, &lobes, &energy, Frame::Shift);
        for &edge in mesh.topology.edges() {
            let plan = facets.plan(&lobes, edge, 0.1);
            assert!(plan.pairs.iter().all(|p| p.start.is_finite() && p.end.is_finite()));
        }
        for (corners, wi) in
            mesh.topology.triangles().iter().map(|t| (*t, mesh.between(&t.map(|v| (v, 1.0 / 3.0)))))
        {
            let cell = (corners, [1.0 / 3.0; 3]);
            let all = facets.moved((&mesh, &lobes, Frame::Shift), cell, wi);
            assert!(all.iter().all(|m| m.lobe.mass.is_finite() && m.peak.is_finite()), "{wi}");
        }
    }
}
