//! The mesh of directions: laws of a triangulation, the empty circle, the degenerate cases.

use std::collections::BTreeSet;

use bsdfkit_sphere::delaunay::{Triangulation, Unmeshable};
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::{DVec2, DVec3};
use proptest::prelude::*;

/// θ–φ grid in degrees, normal incidence once if `pole`.
fn grid(theta_step: usize, phi_step: usize, phi_end: usize, pole: bool) -> Vec<DVec3> {
    let mut points = if pole { vec![DVec3::Z] } else { Vec::new() };
    for theta in (theta_step..=80).step_by(theta_step) {
        for phi in (0..360.min(phi_end + 1)).step_by(phi_step) {
            points.push(from_degrees(theta as f64, phi as f64));
        }
    }
    points
}

/// Triangle's doubled area in the disk.
fn area(points: &[DVec3], t: [u32; 3]) -> f64 {
    let [a, b, c] = t.map(|v| points[v as usize].truncate());
    (b - a).perp_dot(c - a)
}

/// Everything that holds for any mesh of an area.
fn check(points: &[DVec3], mesh: &Triangulation) {
    let triangles = mesh.triangles();
    assert!(!mesh.is_chain());
    assert_eq!(mesh.vertex_count(), points.len());
    let used: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
    assert_eq!(used.len(), points.len(), "each point is a vertex");

    // Euler's formula for a disk, and its consequence for the number of triangles.
    assert_eq!(points.len() + triangles.len(), mesh.edges().len() + 1);
    assert_eq!(triangles.len() + 2 + mesh.boundary().len(), 2 * points.len());

    // One closed outline, and the triangles fill what it encloses without overlap.
    for pair in mesh.boundary().windows(2) {
        assert_eq!(pair[0][1], pair[1][0]);
    }
    assert_eq!(mesh.boundary().first().map(|e| e[0]), mesh.boundary().last().map(|e| e[1]));
    let enclosed: f64 = (mesh.boundary().iter())
        .map(|&[a, b]| points[a as usize].truncate().perp_dot(points[b as usize].truncate()))
        .sum();
    assert!(triangles.iter().all(|&t| area(points, t) > 0.0));
    let covered: f64 = triangles.iter().map(|&t| area(points, t)).sum();
    assert!((covered - enclosed).abs() < 1e-12, "{covered} of {enclosed}");

    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[(k + 1) % 3], t[(k + 2) % 3]);
            let edge = mesh.edges()[mesh.triangle_edges()[i][k] as usize];
            assert_eq!(edge, [a.min(b), a.max(b)]);
            assert_eq!(mesh.edge_between(b, a), Some(mesh.triangle_edges()[i][k]));
            match mesh.neighbours()[i][k] {
                None => assert!(mesh.boundary().contains(&[a, b])),
                Some(n) => {
                    let other = triangles[n as usize];
                    let j = (0..3).find(|&j| other[j] != a && other[j] != b).expect("third");
                    assert_eq!([other[(j + 1) % 3], other[(j + 2) % 3]], [b, a]);
                    assert_eq!(mesh.neighbours()[n as usize][j], Some(i as u32));
                }
            }
        }
        // The cap through the corners holds no other point.
        let [a, b, c] = t.map(|v| points[v as usize]);
        let side = a.z.signum();
        let axis = DVec3::new(1.0, 1.0, side) * {
            let up = |p: DVec3| DVec3::new(p.x, p.y, p.z * side);
            (up(b) - up(a)).cross(up(c) - up(a)).normalize()
        };
        let worst = points.iter().map(|&p| axis.dot(p - a)).fold(f64::MIN, f64::max);
        assert!(worst < 1e-8, "a point {worst} inside the circle of triangle {t:?}");
    }
}

#[test]
fn grids_of_all_kinds() {
    for theta_step in [10, 15] {
        for phi_step in [15, 30, 90] {
            for (phi_end, pole) in [(360, true), (360, false), (180, true), (90, true), (90, false)]
            {
                let points = grid(theta_step, phi_step, phi_end, pole);
                let mesh = Triangulation::new(&points).expect("mesh");
                check(&points, &mesh);
                // The outline is that of the grid: no needle, no point skipped.
                let rings = 80 / theta_step;
                let spokes = 360.min(phi_end + 1).div_ceil(phi_step);
                let outline = match (phi_end, pole) {
                    (360, _) => spokes,
                    (_, true) => spokes - 1 + 2 * rings,
                    // The innermost ring is closed by one chord between the arms.
                    (_, false) => spokes - 1 + 2 * (rings - 1) + 1,
                };
                assert_eq!(mesh.boundary().len(), outline, "{theta_step} {phi_step} {phi_end}");
            }
        }
    }
}

#[test]
fn diagonals_are_mirrored() {
    let points = grid(10, 15, 360, true);
    let mesh = Triangulation::new(&points).expect("mesh");
    let find = |p: DVec3| points.iter().position(|q| q.distance(p) < 1e-9).expect("image") as u32;
    let edges: BTreeSet<[u32; 2]> = mesh.edges().iter().copied().collect();
    for mirror in [DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0)] {
        for edge in mesh.edges() {
            let [a, b] = edge.map(|v| find(points[v as usize] * mirror));
            assert!(edges.contains(&[a.min(b), a.max(b)]), "edge {edge:?} has no mirror image");
        }
    }
}

#[test]
fn the_order_of_points_does_not_matter() {
    let points = grid(10, 30, 360, true);
    let n = points.len();
    let shuffled: Vec<usize> = (0..n).map(|i| (i * 29 + 7) % n).collect();
    assert_eq!(shuffled.iter().collect::<BTreeSet<_>>().len(), n);
    let mesh = Triangulation::new(&points).expect("mesh");
    let other: Vec<DVec3> = shuffled.iter().map(|&i| points[i]).collect();
    let other = Triangulation::new(&other).expect("mesh");
    let renamed: BTreeSet<[u32; 2]> = (other.edges().iter())
        .map(|e| e.map(|v| shuffled[v as usize] as u32))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    assert_eq!(renamed, mesh.edges().iter().copied().collect());
}

#[test]
fn the_back_side_gives_the_same_mesh() {
    let points = grid(15, 30, 180, true);
    let back: Vec<DVec3> = points.iter().map(|p| p.with_z(-p.z)).collect();
    assert_eq!(Triangulation::new(&points), Triangulation::new(&back));
}

#[test]
fn one_plane_of_incidence_is_a_chain() {
    for azimuth in [0.0, 30.0, 90.0, 137.0] {
        let thetas = [30.0, 0.0, -60.0, 80.0, 10.0, -20.0];
        let points = thetas.map(|t| from_degrees(t, azimuth));
        let mesh = Triangulation::new(&points).expect("mesh");
        assert!(mesh.is_chain());
        let mut chain: Vec<f64> = mesh.boundary().iter().map(|e| thetas[e[0] as usize]).collect();
        chain.extend(mesh.boundary().last().map(|e| thetas[e[1] as usize]));
        if chain[0] > 0.0 {
            chain.reverse();
        }
        assert_eq!(chain, [-60.0, -20.0, 0.0, 10.0, 30.0, 80.0]);
        assert_eq!(mesh.edges().len(), 5);
        assert!(mesh.boundary().iter().all(|&[a, b]| mesh.edge_between(a, b).is_some()));
        assert_eq!(mesh.edge_between(2, 3), None);
    }
    let one = Triangulation::new(&[DVec3::Z]).expect("mesh");
    assert_eq!((one.vertex_count(), one.edges().len(), one.is_chain()), (1, 0, true));
    let two = Triangulation::new(&[from_degrees(10.0, 0.0), DVec3::Z]).expect("mesh");
    assert_eq!((two.edges(), two.boundary()), (&[[0, 1]][..], &[[1, 0]][..]));
}

#[test]
fn a_noisy_straight_outline_has_no_needles() {
    // A half-turn measured with 0.1° of play in φ: the outline keeps all points of both arms.
    let mut points = grid(10, 30, 180, true);
    for (i, p) in points.iter_mut().enumerate() {
        let (theta, phi) = bsdfkit_sphere::direction::to_degrees(*p);
        *p = from_degrees(theta, phi + 0.1 * ((i * 7 % 5) as f64 / 4.0 - 0.5));
    }
    let mesh = Triangulation::new(&points).expect("mesh");
    check(&points, &mesh);
    assert_eq!(mesh.boundary().len(), 7 + 7 + 7 + 1);
}

#[test]
fn rubbish_is_refused() {
    let z = DVec3::Z;
    let slanted = from_degrees(40.0, 10.0);
    assert_eq!(Triangulation::new(&[]), Err(Unmeshable::Empty));
    assert_eq!(Triangulation::new(&[z, 2.0 * z]), Err(Unmeshable::NotUnit { index: 1 }));
    assert_eq!(Triangulation::new(&[z, DVec3::NAN]), Err(Unmeshable::NotUnit { index: 1 }));
    assert_eq!(
        Triangulation::new(&[slanted, -z]),
        Err(Unmeshable::BothSides { first: 0, second: 1 })
    );
    assert_eq!(
        Triangulation::new(&[slanted, z, slanted + 1e-9 * DVec3::X]),
        Err(Unmeshable::Duplicate { first: 0, second: 2 })
    );
    let message = Unmeshable::Duplicate { first: 0, second: 2 }.to_string();
    assert!(message.contains("directions 0 and 2"), "{message}");
}

fn scattered(n: std::ops::Range<usize>) -> impl Strategy<Value = Vec<DVec3>> {
    let point = (0.0_f64..1.0, 0.0_f64..360.0);
    proptest::collection::vec(point, n).prop_map(|polar| {
        polar.into_iter().map(|(z, phi)| from_degrees(z.acos().to_degrees(), phi)).collect()
    })
}

proptest! {
    #[test]
    fn scattered_points_make_a_mesh(points in scattered(3..120)) {
        match Triangulation::new(&points) {
            Ok(mesh) if !mesh.is_chain() => check(&points, &mesh),
            Ok(_) => prop_assert!(points.len() < 6),
            Err(fault) => return Err(TestCaseError::reject(fault.to_string())),
        }
    }

    /// Integer lattices in the disk: masses of points on common circles and lines.
    #[test]
    fn lattices_make_a_mesh(step in 0.11_f64..0.5, turn in 0.0_f64..6.3, shift in 0.0_f64..0.4) {
        let turn = DVec2::from_angle(turn);
        let points: Vec<DVec3> = (-9_i32..=9)
            .flat_map(|i| (-9_i32..=9).map(move |j| DVec2::new(f64::from(i), f64::from(j))))
            .map(|p| turn.rotate(p * step + DVec2::splat(shift)))
            .filter(|p| p.length_squared() < 1.0)
            .map(|p| p.extend((1.0 - p.length_squared()).sqrt()))
            .collect();
        if let Ok(mesh) = Triangulation::new(&points) && !mesh.is_chain() {
            check(&points, &mesh);
        } else {
            prop_assert!(points.len() < 5);
        }
    }
}

#[test]
fn two_thousand_points_in_no_time() {
    let points: Vec<DVec3> = (0..2000)
        .map(|i| {
            let z = 1.0 - (f64::from(i) + 0.5) / 2000.0;
            from_degrees(z.acos().to_degrees(), f64::from(i) * 137.507_764)
        })
        .collect();
    let start = std::time::Instant::now();
    let mesh = Triangulation::new(&points).expect("mesh");
    assert!(start.elapsed().as_secs_f64() < 1.0, "took {:?}", start.elapsed());
    println!("2000 points: {:?}", start.elapsed());
    check(&points, &mesh);
}

#[test]
fn cells_of_a_grid_may_be_joined_along_the_other_diagonal() {
    let points = grid(20, 30, 360, true);
    let mesh = Triangulation::new(&points).unwrap();
    let mut asked = Vec::new();
    let turned = mesh.clone().with_diagonals(&points, |other, joined| {
        asked.push((other, joined));
        true
    });
    check(&points, &turned);
    // Three rings of twelve cells between four rings of points, each asked about once.
    assert_eq!(asked.len(), 36);
    for (other, joined) in asked {
        assert!(mesh.edge_between(joined[0], joined[1]).is_some());
        assert!(turned.edge_between(joined[0], joined[1]).is_none());
        assert!(turned.edge_between(other[0], other[1]).is_some());
    }
    assert_eq!(mesh.clone().with_diagonals(&points, |_, _| false), mesh);
    // Where no four points share a circle there is nothing to choose.
    let scattered: Vec<DVec3> =
        (0..40).map(|k| from_degrees(2.0 * f64::from(k), 137.508 * f64::from(k))).collect();
    let mesh = Triangulation::new(&scattered).unwrap();
    assert_eq!(mesh.clone().with_diagonals(&scattered, |_, _| true), mesh);
    let chain: Vec<DVec3> = [0.0, 20.0, 50.0].map(|t| from_degrees(t, 0.0)).to_vec();
    let mesh = Triangulation::new(&chain).unwrap();
    assert_eq!(mesh.clone().with_diagonals(&chain, |_, _| true), mesh);
}
