//! Peaks that follow a facet from incidence to incidence.
//!
//! Each peak of transmitted light is asked whether it goes, over all measured incidences, where and as
//! bright as some [`Facet`] would have it. One that does is carried by the facet between incidences and
//! past the last of them. What the facet does not explain of energy, place and shape is
//! interpolated as ever, and other peaks are left alone.

use bsdfkit::{DVec2, DVec3};

use crate::interpolant::facet::facet::Facet;
use crate::interpolant::facet::refracted_lobe::{Carried, Place, Shape};
use crate::interpolant::mesh::incidence_mesh::{IncidenceMesh, Vertex};
use crate::interpolant::motion::moved::Moved;
use crate::lobe::{Covariance, Lobe, LobeSet};
use bsdfkit_measure::frame::{Frame, FrameAt};

/// The facets of a component, and the lobes that follow them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Facets {
    pub(super) facets: Vec<Followed>,
    /// Of each vertex and lobe: its facet.
    pub(super) of: Vec<Vec<Option<u8>>>,
}

/// A facet that peaks follow.
#[derive(Clone, Debug)]
pub(super) struct Followed {
    pub(super) facet: Facet,
    pub(super) shape: Shape,
    /// Of each vertex: how much it has to say of the peak elsewhere.
    pub(super) say: Vec<f64>,
    /// Where each vertex has its peak, and how bright.
    pub(super) at: Vec<Option<(Place, f64)>>,
}

impl Facets {
    /// Whether a lobe follows a facet.
    pub(crate) fn rules(&self, vertex: u32, lobe: u16) -> bool {
        let of = self.of.get(vertex as usize).and_then(|of| of.get(lobe as usize));
        of.is_some_and(Option::is_some)
    }

    /// The same where each vertex has its places in the frame, by which [`Facets::moved`] goes.
    pub(super) fn placed(mut self, mesh: &IncidenceMesh, frame: Frame) -> Self {
        for followed in &mut self.facets {
            let at = |v: &Vertex| followed.place(v.wi, &frame.at(v.wi));
            followed.at = mesh.vertices.iter().map(at).collect();
        }
        self
    }

    /// The lobes of a cell that follow facets, at `wi`, whose frame is `at`, and weights `lambda` of its corners: each corner's
    /// where its facet carries them, as bright as that has them; with `near` those alone that are seen at this place of the frame.
    /// They are blended: those of one peak, fitted at two incidences, divide it in different ways, and between partners that are
    /// not alike it would be too narrow half-way.
    pub(crate) fn moved(
        &self,
        lobes: &[LobeSet],
        (corners, lambda): ([u32; 3], [f64; 3]),
        (wi, at): (DVec3, &FrameAt),
        near: Option<DVec2>,
    ) -> Vec<Moved> {
        let mut all = Vec::new();
        for (k, followed) in self.facets.iter().enumerate() {
            let own = |v: u32| {
                let of = lobes[v as usize].lobes.iter().zip(&self.of[v as usize]);
                of.filter(move |(_, of)| **of == Some(k as u8)).map(|(lobe, _)| *lobe)
            };
            let Some((here, energy)) = followed.place(wi, at) else { continue };
            let corner = |v: usize| {
                let there = lambda[v] > 0.0 && own(corners[v]).next().is_some();
                followed.at[corners[v] as usize].filter(|_| there)
            };
            let from = [0, 1, 2].map(corner);
            // Of corners where little is left, which says little, little is made.
            let weight = [0, 1, 2].map(|v| lambda[v] * followed.say[corners[v] as usize]);
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
                for lobe in own(corners[v]) {
                    let mass = weight[v] * lobe.mass * energy / whole;
                    let lobe = carried.lobe(Lobe { mass, ..lobe });
                    if near.is_some_and(|q| !lobe.covariance.reaches(q - lobe.mean)) {
                        continue;
                    }
                    // Other corners are asked where the facet has them, or, without it, at the same place.
                    let back = |corner: Option<(Place, f64)>| match corner {
                        Some((to, _)) => {
                            let there = Carried { from: here, to }.lobe(lobe);
                            (there.mean, lobe.covariance.transport_to(there.covariance))
                        }
                        None => (lobe.mean, Covariance::isotropic(1.0)),
                    };
                    let moved = Moved::new(lobe, from.map(back), shares);
                    all.push(Moved { facet: Some(k as u8), ..moved });
                }
            }
        }
        all
    }
}

impl Followed {
    /// Where the facet has the peak of light from `wi`, whose frame is `at`, and how bright.
    fn place(&self, wi: DVec3, at: &FrameAt) -> Option<(Place, f64)> {
        let passed = self.facet.pass(wi)?;
        Some((self.shape.at(passed.u, at), passed.energy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::facet::facet::Passed;
    use crate::interpolant::facet::search::together;
    use crate::interpolant::motion::edge_plan::EdgePlan;
    use bsdfkit_measure::Symmetry;
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

    fn free_plan(facets: &Facets, lobes: &[LobeSet], edge: [u32; 2]) -> EdgePlan {
        let free = edge.map(|v| move |i: usize| !facets.rules(v, i as u16));
        EdgePlan::among(edge.map(|v| &lobes[v as usize]), &free, 0.1)
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
            let plan = free_plan(&facets, &lobes, edge);
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
            let moved =
                facets.moved(lobes, (corners, barycentric), (wi, &Frame::Shift.at(wi)), None);
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
        let all = facets.moved(lobes, (corners, barycentric), (wi, &Frame::Shift.at(wi)), None);
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
            let plan = free_plan(&facets, &lobes, edge);
            assert!(plan.pairs.iter().all(|p| p.start.is_finite() && p.end.is_finite()));
        }
        for (corners, wi) in
            mesh.topology.triangles().iter().map(|t| (*t, mesh.between(&t.map(|v| (v, 1.0 / 3.0)))))
        {
            let cell = (corners, [1.0 / 3.0; 3]);
            let all = facets.moved(&lobes, cell, (wi, &Frame::Shift.at(wi)), None);
            assert!(all.iter().all(|m| m.lobe.mass.is_finite() && m.peak.is_finite()), "{wi}");
        }
    }
}
