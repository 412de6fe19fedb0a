//! Point location against brute force, and its continuity.

use bsdfkit_sphere::delaunay::Triangulation;
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::locate::{Location, Locator};
use bsdfkit_sphere::{DVec2, DVec3};
use proptest::prelude::*;

struct Case {
    positions: Vec<DVec2>,
    mesh: Triangulation,
    locator: Locator,
}

fn case(points: &[DVec3]) -> Option<Case> {
    let mesh = Triangulation::new(points).ok()?;
    let positions: Vec<DVec2> = points.iter().map(|p| p.truncate()).collect();
    let locator = Locator::new(&mesh, &positions)?;
    Some(Case { positions, mesh, locator })
}

fn grid(theta_step: usize, phi_step: usize, phi_end: usize) -> Vec<DVec3> {
    let mut points = vec![DVec3::Z];
    for theta in (theta_step..=80).step_by(theta_step) {
        for phi in (0..360.min(phi_end + 1)).step_by(phi_step) {
            points.push(from_degrees(theta as f64, phi as f64));
        }
    }
    points
}

impl Case {
    /// Where the location says the point is: itself, or the nearest outline point.
    fn place(&self, location: Location) -> DVec2 {
        let weights = location.weights(&self.mesh);
        weights.iter().map(|&(v, w)| self.positions[v as usize] * w).sum()
    }

    /// Triangles that hold `p` by more than rounding.
    fn holders(&self, p: DVec2) -> Vec<u32> {
        let holds = |t: &[u32; 3]| {
            (0..3).all(|k| {
                let (a, b) = (t[(k + 1) % 3] as usize, t[(k + 2) % 3] as usize);
                let (a, b) = (self.positions[a], self.positions[b]);
                (b - a).perp_dot(p - a) > 1e-14
            })
        };
        (0..).zip(self.mesh.triangles()).filter(|(_, t)| holds(t)).map(|(i, _)| i).collect()
    }

    /// Least distance to the outline, by many points on each edge.
    fn distance_by_steps(&self, p: DVec2) -> f64 {
        let on = |e: &[u32; 2], s: i32| {
            let [a, b] = e.map(|v| self.positions[v as usize]);
            a.lerp(b, f64::from(s) / 200.0).distance(p)
        };
        let steps = |e| (0..=200).map(move |s| on(e, s));
        self.mesh.boundary().iter().flat_map(steps).fold(f64::MAX, f64::min)
    }

    fn check(&self, p: DVec2) {
        let location = self.locator.locate(p);
        let holders = self.holders(p);
        match location {
            Location::Inside { triangle, barycentric } => {
                assert!(holders.is_empty() || holders == [triangle], "{p}: {holders:?}");
                assert!(barycentric.iter().all(|&w| w >= 0.0));
                assert!((barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-15);
                assert!(self.place(location).distance(p) < 1e-14, "{p}");
            }
            Location::Outside { fraction, distance, .. } => {
                assert!(holders.is_empty(), "{p} is in {holders:?}");
                assert!((0.0..=1.0).contains(&fraction));
                assert!((self.place(location).distance(p) - distance).abs() < 1e-14);
                let stepped = self.distance_by_steps(p);
                assert!(distance <= stepped + 1e-12 && stepped < distance + 0.01, "{p}");
            }
        }
    }
}

#[test]
fn grids_agree_with_brute_force() {
    for (theta_step, phi_step, phi_end) in
        [(10, 15, 360), (15, 30, 180), (10, 30, 90), (40, 120, 360)]
    {
        let case = case(&grid(theta_step, phi_step, phi_end)).expect("mesh");
        for i in -25..=25 {
            for j in -25..=25 {
                case.check(DVec2::new(f64::from(i), f64::from(j)) / 24.7);
            }
        }
        // On vertices and on edges.
        for &p in &case.positions {
            case.check(p);
        }
        for e in case.mesh.edges() {
            let [a, b] = e.map(|v| case.positions[v as usize]);
            case.check(a.lerp(b, 0.3));
        }
    }
}

#[test]
fn a_million_queries_take_no_time() {
    let case = case(&grid(5, 5, 360)).expect("mesh");
    let start = std::time::Instant::now();
    let inside = (0..1_000_000_u32)
        .map(|i| DVec2::new(f64::from(i % 1000), f64::from(i / 1000)) / 500.0 - DVec2::ONE)
        .filter(|&p| matches!(case.locator.locate(p), Location::Inside { .. }))
        .count();
    let took = start.elapsed();
    println!("{} triangles, 1e6 queries: {took:?}", case.mesh.triangles().len());
    assert!(took.as_secs_f64() < 10.0, "{took:?}");
    // The share of the square that the 72-sided rim at 80° fills.
    let rim = 36.0 * 80_f64.to_radians().sin().powi(2) * 5_f64.to_radians().sin() / 4.0;
    assert!((inside as f64 * 1e-6 - rim).abs() < 1e-4);
}

#[test]
fn a_vertex_is_itself() {
    let case = case(&grid(10, 30, 360)).expect("mesh");
    for (v, &p) in case.positions.iter().enumerate() {
        let weights = case.locator.locate(p).weights(&case.mesh);
        let own: f64 = weights.iter().filter(|w| w.0 as usize == v).map(|w| w.1).sum();
        assert_eq!(own, 1.0, "vertex {v}: {weights:?}");
    }
}

#[test]
fn the_place_moves_no_further_than_the_point() {
    // The nearest point of a convex region is a contraction: any jump would show.
    for phi_end in [90, 180, 360] {
        let case = case(&grid(10, 15, phi_end)).expect("mesh");
        let turn = |s: i32| 1.05 * DVec2::from_angle(f64::from(s) * 1e-3);
        for s in 0..6284 {
            let (p, q) = (turn(s), turn(s + 1));
            let (a, b) = (case.locator.locate(p), case.locator.locate(q));
            assert!(case.place(a).distance(case.place(b)) <= p.distance(q) + 1e-12, "{p}");
        }
    }
}

#[test]
fn chains_and_single_points() {
    let points = [0.0, 30.0, 60.0].map(|t| from_degrees(t, 0.0));
    let chain = case(&points).expect("mesh");
    let x = 0.7 * chain.positions[1].x + 0.3 * chain.positions[2].x;
    let Location::Outside { edge, fraction, distance } = chain.locator.locate(DVec2::new(x, 0.2))
    else {
        panic!("a chain has no inside")
    };
    assert_eq!(edge, [1, 2]);
    assert!((fraction - 0.3).abs() < 1e-15 && (distance - 0.2).abs() < 1e-15);
    let single = case(&[DVec3::Z]).expect("mesh");
    let far = single.locator.locate(DVec2::new(0.3, 0.4));
    assert_eq!(far, Location::Outside { edge: [0, 0], fraction: 0.0, distance: 0.5 });
    for c in [chain, single, case(&grid(10, 15, 360)).expect("mesh")] {
        let nan = c.locator.locate(DVec2::new(f64::NAN, 0.0));
        assert!(matches!(nan, Location::Outside { fraction, distance, .. }
            if fraction.is_nan() && distance.is_nan()));
    }
}

#[test]
fn other_positions_are_refused() {
    let mesh = Triangulation::new(&grid(40, 90, 360)).expect("mesh");
    assert!(Locator::new(&mesh, &[DVec2::ZERO]).is_none());
    assert!(Locator::new(&mesh, &vec![DVec2::NAN; mesh.vertex_count()]).is_none());
}

proptest! {
    #[test]
    fn scattered_points_agree_with_brute_force(
        polar in proptest::collection::vec((0.0_f64..1.0, 0.0_f64..360.0), 1..80),
        queries in proptest::collection::vec((-1.1_f64..1.1, -1.1_f64..1.1), 50),
    ) {
        let points: Vec<DVec3> =
            polar.iter().map(|&(z, phi)| from_degrees(z.acos().to_degrees(), phi)).collect();
        if let Some(case) = case(&points) && points.len() > 1 {
            for (x, y) in queries {
                case.check(DVec2::new(x, y));
            }
        }
    }
}
