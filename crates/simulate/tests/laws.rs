//! The laws that the materials state, found again: peaks searched for and their energy summed over fine cells of the
//! projected disk, beside what angles and tangents say.

use bsdfkit_simulate::Material;
use bsdfkit_simulate::material::{
    ClearCoat, CrossedThreads, GratingFilm, HazeAndBeam, RotatedMetal, SquareDiffuser,
    ThreeFacetFilm, Velvet,
};
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::{DVec2, DVec3};

/// Energy within `radius` of `centre` on the projected disk, less a floor of f, and where its middle lies.
fn around(m: &dyn Material, wi: DVec3, centre: DVec2, radius: f64, floor: f64) -> (f64, DVec2) {
    const CELLS: i32 = 300;
    let h = 2.0 * radius / f64::from(CELLS);
    let (mut energy, mut middle) = (0.0, DVec2::ZERO);
    for k in 0..CELLS * CELLS {
        let at = DVec2::new(f64::from(k / CELLS) + 0.5, f64::from(k % CELLS) + 0.5) * h - radius;
        let u = centre + at;
        if at.length() > radius || u.length() >= 1.0 {
            continue;
        }
        let wo = u.extend(m.scattered().sign() * (1.0 - u.length_squared()).sqrt());
        let light = h * h * (m.eval(wi, wo) - floor);
        energy += light;
        middle += light * u;
    }
    (energy, middle / energy)
}

fn unpolarised(theta: f64, n: f64) -> f64 {
    // by angles, where the materials go by cosines
    let inside = (theta.sin() / n).asin();
    if theta == 0.0 {
        return ((n - 1.0) / (n + 1.0)).powi(2);
    }
    let s = ((theta - inside).sin() / (theta + inside).sin()).powi(2);
    let p = ((theta - inside).tan() / (theta + inside).tan()).powi(2);
    0.5 * (s + p)
}

#[test]
fn orders_of_the_grating_stand_where_its_equation_says() {
    let m = GratingFilm { diffuse: 0.0, width: 0.02, ..GratingFilm::default() };
    for theta in [0.0f64, 20.0, 35.0] {
        let wi = from_degrees(theta, 0.0);
        for (order, efficiency) in
            [(-2.0, 0.04), (-1.0, 0.1), (0.0, 0.35), (1.0, 0.22), (2.0, 0.09)]
        {
            let sine = order * 0.34 - theta.to_radians().sin();
            if sine.abs() > 0.9 {
                continue;
            }
            let (energy, middle) = around(&m, wi, DVec2::new(sine, 0.0), 0.1, 0.0);
            assert!((energy - efficiency).abs() < 1e-4, "{theta} {order}: {energy}");
            assert!((middle - DVec2::new(sine, 0.0)).length() < 1e-4, "{theta} {order}: {middle}");
        }
    }
}

#[test]
fn facets_refract_by_their_angles() {
    let m = ThreeFacetFilm { diffuse: 0.0, beam_degrees: 1.0, ..ThreeFacetFilm::default() };
    let n: f64 = 1.53;
    for theta in [0.0f64, 12.0, 25.0] {
        // in the plane across the prisms; angles of travel from −Z toward +X
        let incidence = -theta.to_radians();
        let inside = (incidence.sin() / n).asin();
        let entering = 1.0 - unpolarised(theta.to_radians(), n);
        for (lean, area) in [(22.0f64, 0.4), (-32.0, 0.3), (0.0, 0.25)] {
            let lean = lean.to_radians();
            let sine = n * (inside - lean).sin();
            if sine.abs() > 0.95 {
                continue;
            }
            let out = lean + sine.asin();
            let leaving = 1.0 - unpolarised(sine.asin().abs(), n);
            let wi = from_degrees(theta, 0.0);
            let (energy, middle) = around(&m, wi, DVec2::new(out.sin(), 0.0), 0.08, 0.0);
            let expected = area * entering * leaving * out.cos() / (0.95 * out.cos() + 0.05);
            assert!((energy / expected - 1.0).abs() < 0.01, "{theta} {lean}: {energy} {expected}");
            assert!((middle.x - out.sin()).abs() < 1e-3 && middle.y.abs() < 1e-6, "{theta} {lean}");
        }
    }
}

#[test]
fn the_base_is_a_metal_seen_through_its_coat() {
    let coat = ClearCoat { coat_roughness: 0.01, ..ClearCoat::default() };
    let base = RotatedMetal {
        roughness_x: 0.07,
        roughness_y: 0.3,
        rotation_degrees: 0.0,
        reflectance: 0.8,
    };
    for (i, o) in
        [((30.0, 90.0), (20.0, 250.0)), ((60.0, 10.0), (50.0, 200.0)), ((10.0, 0.0), (45.0, 95.0))]
    {
        let inside = |(theta, phi): (f64, f64)| {
            from_degrees((theta.to_radians().sin() / 1.5).asin().to_degrees(), phi)
        };
        let through = |theta: f64| 1.0 - unpolarised(theta.to_radians(), 1.5);
        let expected = through(i.0) * through(o.0) / 2.25 * base.eval(inside(i), inside(o));
        let f = coat.eval(from_degrees(i.0, i.1), from_degrees(o.0, o.1));
        // beside the mirror direction the coat has only its tail
        assert!(f >= expected && f < expected * 1.02 + 2e-3, "{i:?} {o:?}: {f} {expected}");
    }
    // the coat alone, at its peak: D F / 4 cos² with D = 1 / (π roughness²)
    let coat =
        ClearCoat { reflectance: 0.0, roughness_x: 0.9, roughness_y: 0.9, ..ClearCoat::default() };
    let wi = from_degrees(60.0, 0.0);
    let peak = unpolarised(60f64.to_radians(), 1.5) / (std::f64::consts::PI * 0.0016);
    let f = coat.eval(wi, from_degrees(60.0, 180.0));
    assert!((f / peak - 1.0).abs() < 0.01, "{f} {peak}");
}

#[test]
fn the_square_is_where_it_was_turned_to() {
    let m = SquareDiffuser { diffuse: 0.0, edge: 0.002, ..SquareDiffuser::default() };
    let wi = from_degrees(20.0, 70.0);
    let entering = 1.0 - unpolarised(20f64.to_radians(), 1.5);
    let (energy, middle) = around(&m, wi, -wi.truncate(), 0.4, 0.0);
    assert!((energy / (0.85 * entering) - 1.0).abs() < 5e-3, "{energy}");
    assert!((middle + wi.truncate()).length() < 1e-3, "{middle}");
    // inside at the corner toward 20° + 45°, outside as far away toward 20°
    let f = |azimuth: f64, radius: f64| {
        let (sin, cos) = azimuth.to_radians().sin_cos();
        let u = radius * DVec2::new(cos, sin) - wi.truncate();
        m.eval(wi, u.extend(-(1.0 - u.length_squared()).sqrt()))
    };
    assert!(f(65.0, 0.34) > 1.0 && f(20.0, 0.34) < 1e-6 && f(20.0, 0.24) > 1.0);
}

#[test]
fn the_beam_turns_into_haze() {
    let m = HazeAndBeam { beam: 0.01, haze: 0.08, ..HazeAndBeam::default() };
    for theta in [0.0f64, 30.0, 55.0] {
        let wi = from_degrees(theta, 40.0);
        let (all, left) = (0.9, (-0.5 / theta.to_radians().cos()).exp());
        let straight = -wi.truncate();
        let (haze, middle) = around(&m, wi, 0.6 * straight, 0.3, 0.0);
        if theta == 0.0 {
            let expected = all * (left + 0.8 * (1.0 - left));
            assert!((haze / expected - 1.0).abs() < 2e-3, "{haze} {expected}");
            continue;
        }
        if theta == 55.0 {
            // the beam is outside of the haze's disk
            assert!((haze / (all * 0.8 * (1.0 - left)) - 1.0).abs() < 2e-3, "{haze}");
            assert!((middle - 0.6 * straight).length() < 1e-3);
        }
        let here = all * 0.8 * (1.0 - left) * gauss(0.4 * straight.length(), 0.08);
        let (beam, middle) = around(&m, wi, straight, 0.04, here);
        assert!((beam / (all * left) - 1.0).abs() < 5e-3, "{theta}: {beam}");
        assert!((middle - straight).length() < 1e-3);
    }
}

fn gauss(off: f64, sigma: f64) -> f64 {
    (-0.5 * (off / sigma).powi(2)).exp() / (2.0 * std::f64::consts::PI * sigma * sigma)
}

#[test]
fn threads_mirror_into_cones() {
    // one thread family at a time: along each line across its streak, the brightest point is on the cone
    for k in 0..2 {
        let mut m =
            CrossedThreads { ground: 0.0, widths: [0.01, 0.01], ..CrossedThreads::default() };
        m.sheens[1 - k] = 0.0;
        m.waves_degrees = [0.0, 0.0];
        let wi = from_degrees(35.0, 25.0);
        let along = if k == 0 { wi.x } else { wi.y };
        for aside in [-0.5, 0.0, 0.4] {
            let f = |s: f64| {
                let u = if k == 0 { DVec2::new(s, aside) } else { DVec2::new(aside, s) };
                m.eval(wi, u.extend((1.0 - u.length_squared()).sqrt()))
            };
            let best =
                (-700..700).map(|i| f64::from(i) * 1e-3).max_by(|a, b| f(*a).total_cmp(&f(*b)));
            assert!((best.unwrap() + along).abs() < 2e-3, "{k} {aside}: {best:?}");
        }
        // a flat thread keeps its energy when lit across, but for what goes round below the horizon
        let (energy, _) = around(&m, from_degrees(0.0, 0.0), DVec2::ZERO, 1.0, 0.0);
        assert!((energy / m.sheens[k] - 1.0).abs() < 0.01, "{k}: {energy}");
    }
}

#[test]
fn velvet_is_the_inverted_gaussian_of_its_angles() {
    let m = Velvet { lean_degrees: 0.0, diffuse: 0.0, ..Velvet::default() };
    let phi = |k: i32| f64::from(k) * 73.0;
    for (k, (i, o)) in [(20.0f64, 30.0f64), (60.0, 75.0), (80.0, 10.0)].into_iter().enumerate() {
        // the half vector's angle, by spherical trigonometry of its two ends
        let [pi, po] = [phi(k as i32), phi(k as i32 + 2)];
        let (a, b) = (from_degrees(i, pi), from_degrees(o, po));
        let half = 0.5 * a.angle_between(b);
        let theta_h = ((a.z + b.z) / (2.0 * half.cos())).acos();
        let density = 1.0 + 4.0 * (-(theta_h.tan() * 0.35).powi(-2)).exp() / theta_h.sin().powi(4);
        let [ci, co] = [i, o].map(|t| t.to_radians().cos());
        let expected = 0.5 * density / (std::f64::consts::PI * 1.49 * 4.0 * (ci + co - ci * co));
        let f = m.eval(a, b);
        assert!((f / expected - 1.0).abs() < 1e-9, "{i} {o}: {f} {expected}");
    }
    // the pile leans toward +X: seen from there, light from above is weaker than from the other side
    let m = Velvet::default();
    let up = from_degrees(0.0, 0.0);
    assert!(m.eval(up, from_degrees(60.0, 0.0)) < m.eval(up, from_degrees(60.0, 180.0)));
}
