//! Which lobes follow which law.
//!
//! A law has a lobe where, in its coordinates, the neighbouring incidences have one at the same place and of the same shape. The
//! law that finds the most of it there has it.

use bsdfkit::{DVec2, DVec3};

use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::lobe::{Covariance, Lobe, LobeSet};
use bsdfkit_measure::frame::{Frame, FrameAt};

/// A law must find so many times as much of a lobe at the neighbours as the motion of all others does.
const MARGIN: f64 = 1.1;
/// Broad lobes stay where they are if so much of them is found there: diffuse light is about as broad in any coordinates.
const DIFFUSE: f64 = 0.8;
/// Fourth root of the determinant of a covariance, in frame coordinates, from which on a lobe may be diffuse light: 10 degrees of
/// direction near the normal, in the frame of half vectors 20.
const BROAD: f64 = 0.17;

/// Of every vertex and lobe: the law that it follows, as a number in `laws`; `None`: that of all others, `frame`.
///
/// Cost: 50 ns for each pair of lobes at neighbouring vertices and law.
pub(crate) fn assigned(
    mesh: &IncidenceMesh,
    lobes: &[LobeSet],
    frame: Frame,
    laws: &[Frame],
) -> Vec<Vec<Option<u8>>> {
    if laws.is_empty() {
        return lobes.iter().map(|set| vec![None; set.lobes.len()]).collect();
    }
    let mut neighbours = vec![Vec::new(); lobes.len()];
    for &[a, b] in mesh.topology.edges() {
        neighbours[a as usize].push(b as usize);
        neighbours[b as usize].push(a as usize);
    }
    let all: Vec<Frame> = std::iter::once(frame).chain(laws.iter().copied()).collect();
    let seen: Vec<Vec<Vec<Option<Lobe>>>> = all
        .iter()
        .map(|&law| {
            (0..lobes.len()).map(|v| in_law(law, frame, mesh.vertices[v].wi, &lobes[v])).collect()
        })
        .collect();
    let of = |v: usize, i: usize| {
        let support = |law: usize| {
            let own = seen[law][v][i]?;
            let found = |&w: &usize| {
                let others = seen[law][w].iter().flatten();
                let best = others.map(|o| alike(&own, o)).fold(0.0, f64::max);
                let near =
                    1.0 / mesh.chart.distance(mesh.vertices[v].wi, mesh.vertices[w].wi).max(1e-3);
                (near * best, near)
            };
            let (sum, all) =
                neighbours[v].iter().map(found).fold((0.0, 1e-300), |s, f| (s.0 + f.0, s.1 + f.1));
            Some(sum / all)
        };
        let rest = support(0).unwrap_or(0.0);
        let broad = lobes[v].lobes[i].covariance.determinant() > BROAD.powi(4);
        let found = |law: usize| {
            let margin = if broad && all[law] == Frame::Fixed { DIFFUSE } else { MARGIN };
            Some((support(law)? / margin, law as u8 - 1))
        };
        let best = (1..all.len()).filter_map(found).max_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|b| b.0 > rest).map(|b| b.1)
    };
    // All images of an incidence are as the first.
    let mut first: Vec<Option<Vec<Option<u8>>>> = vec![None; lobes.len()];
    let each = mesh.vertices.iter().enumerate().map(|(v, vertex)| {
        let all = || (0..lobes[v].lobes.len()).map(|i| of(v, i)).collect();
        first[vertex.incidence].get_or_insert_with(all).clone()
    });
    each.collect()
}

/// The lobes in coordinates of a law; `None` of what is below the horizon.
fn in_law(law: Frame, frame: Frame, wi: DVec3, set: &LobeSet) -> Vec<Option<Lobe>> {
    let (law, at) = (law.at(wi), frame.at(wi));
    set.lobes.iter().map(|lobe| turned(lobe, &at, &law)).collect()
}

/// The lobe in other coordinates, as its axes go there.
pub(crate) fn turned(lobe: &Lobe, from: &FrameAt, to: &FrameAt) -> Option<Lobe> {
    let place = |q: DVec2| {
        let (u, z) = from.inverse(q);
        (z > 0.0).then(|| to.forward(u))
    };
    let mean = place(lobe.mean)?;
    let [a, b] = lobe.covariance.axes().map(|axis| {
        match (place(lobe.mean + axis), place(lobe.mean - axis)) {
            (Some(p), Some(q)) => 0.5 * (p - q),
            (Some(p), None) => p - mean,
            (None, Some(q)) => mean - q,
            (None, None) => axis,
        }
    });
    let covariance = Covariance {
        xx: a.x * a.x + b.x * b.x,
        xy: a.x * a.y + b.x * b.y,
        yy: a.y * a.y + b.y * b.y,
    };
    (covariance.determinant() > 1e-18).then_some(Lobe { mass: lobe.mass, mean, covariance })
}

/// Overlap of two lobes (Bhattacharyya), 1 of equal ones, less the less alike their masses are.
fn alike(a: &Lobe, b: &Lobe) -> f64 {
    let (c, d) = (a.covariance, b.covariance);
    let mean =
        Covariance { xx: 0.5 * (c.xx + d.xx), xy: 0.5 * (c.xy + d.xy), yy: 0.5 * (c.yy + d.yy) };
    let e = mean.inverse().quadratic(a.mean - b.mean) / 8.0;
    if e > 16.0 {
        return 0.0;
    }
    let shapes = (c.determinant() * d.determinant()).powf(0.25) / mean.determinant().sqrt();
    let masses = (a.mass.min(b.mass) / a.mass.max(b.mass).max(1e-300)).max(0.0).powf(0.25);
    shapes * (-e).exp() * masses
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_measure::Symmetry;
    use bsdfkit_sphere::direction::from_degrees;

    /// A mirror's peak and one that goes back, as wide; incidences of a chain.
    fn scene() -> (IncidenceMesh, Vec<LobeSet>) {
        let wi: Vec<DVec3> = [10.0, 25.0, 40.0, 55.0].map(|t| from_degrees(t, 0.0)).to_vec();
        let mesh = IncidenceMesh::new(&wi, Symmetry::Isotropic).expect("mesh");
        let set = |w: DVec3| {
            let at = Frame::Turned.at(w);
            let lobe = |mass: f64, u: DVec2| Lobe {
                mass,
                mean: at.forward(u),
                covariance: Covariance::isotropic(2e-3),
            };
            LobeSet { floor: 0.1, lobes: vec![lobe(0.3, -w.truncate()), lobe(0.2, w.truncate())] }
        };
        let lobes = mesh.vertices.iter().map(|v| set(v.wi)).collect();
        (mesh, lobes)
    }

    #[test]
    fn a_lobe_goes_to_the_law_that_finds_it_at_the_neighbours() {
        let (mesh, lobes) = scene();
        let of = assigned(&mesh, &lobes, Frame::Turned, &[Frame::Fixed, Frame::Back]);
        assert!(of.iter().all(|of| *of == [None, Some(1)]), "{of:?}");
        let none = assigned(&mesh, &lobes, Frame::Turned, &[]);
        assert!(none.iter().all(|of| *of == [None, None]));
    }

    #[test]
    fn coordinates_change_as_the_axes_do() {
        let wi = from_degrees(40.0, 20.0);
        let (from, to) = (Frame::Fixed.at(wi), Frame::Shift.at(wi));
        let covariance = Covariance { xx: 0.01, xy: 0.002, yy: 0.004 };
        let lobe = Lobe { mass: 0.4, mean: DVec2::new(0.1, -0.2), covariance };
        let there = turned(&lobe, &from, &to).expect("above the horizon");
        assert!((there.mean - (lobe.mean + wi.truncate())).length() < 1e-12);
        let c = there.covariance;
        let off = (c.xx - 0.01).abs() + (c.xy - 0.002).abs() + (c.yy - 0.004).abs();
        assert!(off < 1e-12, "{c:?}");
        assert!(turned(&Lobe { mean: DVec2::new(1.2, 0.0), ..lobe }, &from, &to).is_none());
    }

    #[test]
    fn lobes_are_alike_by_place_shape_and_mass() {
        let lobe = |mass: f64, x: f64, v: f64| Lobe {
            mass,
            mean: DVec2::new(x, 0.0),
            covariance: Covariance::isotropic(v),
        };
        let one = lobe(1.0, 0.0, 0.01);
        assert!((alike(&one, &one) - 1.0).abs() < 1e-12);
        // Two deviations apart: exp(−4/8).
        assert!((alike(&one, &lobe(1.0, 0.2, 0.01)) - (-0.5f64).exp()).abs() < 1e-12);
        assert!((alike(&one, &lobe(16.0, 0.0, 0.01)) - 0.5).abs() < 1e-12);
        // Four times as wide: √(√(d₁ d₂)) / √d of the mean = 0.4 / 2.5^½ ... = 2·0.02 / 0.05.
        assert!((alike(&one, &lobe(1.0, 0.0, 0.04)) - 0.8).abs() < 1e-12);
        assert_eq!(alike(&one, &lobe(1.0, 9.0, 0.01)), 0.0);
    }
}
