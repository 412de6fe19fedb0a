//! Incident directions that are proposed: where errors are, within limits, apart from each other.

mod support;

use std::sync::atomic::AtomicBool;

use bsdfkit::{DVec3, ErrorClass, Side};
use bsdfkit_fit::interpolant::{Component, Fitted, Frame};
use bsdfkit_fit::survey::{Limits, Proposal, Subject, begin, propose};
use bsdfkit_fit::validate::{ErrorModel, Validation};
use bsdfkit_measure::{Measurement, Mirror, Symmetry};
use bsdfkit_represent::Watch;
use bsdfkit_simulate::material::{BrushedMetal, FrittedGlass};
use bsdfkit_sphere::direction::{from_degrees, to_degrees};
use support::{coarse, fit, given, grid, measured};

struct Known {
    component: Component,
    validation: Validation,
    model: ErrorModel,
}

impl Known {
    fn of(m: &Measurement, frame: Frame) -> Self {
        let component = fit(m, &given(frame));
        let validation = Validation::of(m, &component, &Watch::default()).expect("validated");
        let model = ErrorModel::of(&component, &validation);
        Self { component, validation, model }
    }

    fn subject(&self) -> Subject<'_> {
        Subject { component: &self.component, validation: &self.validation, model: &self.model }
    }

    fn propose(&self, limits: &Limits, budget: usize) -> Vec<Proposal> {
        propose(&[self.subject()], limits, budget, &Watch::default()).expect("proposals")
    }
}

const LIMITS: Limits = Limits { max_theta_degrees: 70.0, spacing_degrees: 5.0 };

fn metal() -> Measurement {
    let angles = grid(&[0.0, 30.0, 60.0], &[0.0, 45.0, 90.0]);
    measured(&coarse(), &BrushedMetal::default(), Symmetry::Quadrilateral, &angles)
}

#[test]
fn proposals_keep_limits_and_take_error_away() {
    let m = metal();
    let known = Known::of(&m, Frame::Half);
    let proposals = known.propose(&LIMITS, 6);
    assert_eq!(proposals.len(), 6);
    let mut all: Vec<DVec3> = m.incidences.iter().map(|i| i.wi).collect();
    let mut last = f64::MAX;
    for p in &proposals {
        let (theta, phi) = to_degrees(p.wi);
        assert!(theta <= 70.0 + 1e-6 && (-1e-6..=90.0 + 1e-6).contains(&phi), "{theta} {phi}");
        for image in Symmetry::Quadrilateral.images() {
            let twin = image.apply(p.wi);
            let apart = |w: DVec3| w.angle_between(twin).to_degrees();
            assert!(all.iter().all(|&w| apart(w) > 4.99), "{theta} {phi}");
            assert!(apart(p.wi) < 1e-6 || apart(p.wi) > 4.99, "{theta} {phi}");
        }
        assert!(p.mean_l1 < last && p.expected_l1 > 0.0, "{p:?}");
        last = p.mean_l1;
        all.push(p.wi);
        for region in &p.regions {
            assert!(Side::of(region.direction) == Side::Front && region.radius_degrees < 40.0);
        }
    }
    // The mirror direction is where a metal wants dense points.
    let first = &proposals[0];
    let mirror = DVec3::new(-first.wi.x, -first.wi.y, first.wi.z);
    let near = |r: &bsdfkit_fit::survey::ScanRegion| {
        r.direction.angle_between(mirror).to_degrees() < r.radius_degrees
    };
    assert!(first.regions.iter().any(near), "{first:?}");
}

/// The specimen changes at one incidence only: that is where to look closer.
#[test]
fn proposals_go_where_incidences_contradict_each_other() {
    let mut m = metal();
    let odd = from_degrees(30.0, 45.0);
    for i in &mut m.incidences {
        let value = if i.wi.distance(odd) < 1e-9 { 0.5 } else { 0.25 };
        i.values.fill(value);
    }
    let known = Known::of(&m, Frame::Fixed);
    for p in known.propose(&LIMITS, 3) {
        let apart = p.wi.angle_between(odd).to_degrees();
        assert!(apart < 32.0, "{apart}: {:?}", to_degrees(p.wi));
    }
}

/// Four incidences round the rim leave a third of all directions outside the mesh.
#[test]
fn rims_are_closed_first() {
    let angles = grid(&[0.0, 35.0, 70.0], &[0.0, 90.0, 180.0, 270.0]);
    let mut m = measured(&coarse(), &BrushedMetal::default(), Symmetry::None, &angles);
    for (k, i) in m.incidences.iter_mut().enumerate() {
        i.values.fill(if k % 2 == 0 { 0.2 } else { 0.3 });
    }
    let known = Known::of(&m, Frame::Fixed);
    let proposals = known.propose(&LIMITS, 4);
    let past = proposals.iter().filter(|p| !known.component.is_measured(p.wi)).count();
    assert_eq!(past, 4, "{proposals:?}");
}

#[test]
fn isotropic_specimens_get_polar_angles_only() {
    let glass = FrittedGlass::default();
    let angles = grid(&[0.0, 20.0, 40.0, 60.0], &[0.0]);
    let m = measured(&coarse(), &glass, Symmetry::Isotropic, &angles);
    let proposals = Known::of(&m, Frame::Turned).propose(&LIMITS, 4);
    assert_eq!(proposals.len(), 4);
    for p in proposals {
        let (theta, _) = to_degrees(p.wi);
        assert!(p.wi.y.abs() < 1e-12 && theta <= 70.0 + 1e-6, "{:?}", p.wi);
        assert!([0.0, 20.0, 40.0, 60.0].iter().all(|t| (t - theta).abs() > 4.99), "{theta}");
    }
}

/// Largest distance from any direction within 70 degrees to the nearest of `wi` or their images.
fn largest_hole(symmetry: Symmetry, wi: &[DVec3], apart: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let images = symmetry.images();
    let limit = 70f64.to_radians().sin();
    let spiral = (0..4000).map(|k| {
        let t = f64::from(k) + 0.5;
        from_degrees((limit * (t / 4000.0).sqrt()).asin().to_degrees(), 137.507_764 * t)
    });
    let nearest = |w: DVec3| {
        let all = wi.iter().flat_map(|v| images.iter().map(|i| i.apply(*v)));
        all.map(|v| apart(v, w)).fold(f64::MAX, f64::min)
    };
    spiral.map(nearest).fold(0.0, f64::max)
}

/// As many directions as a grid has leave much smaller holes: a grid crowds at the normal and lies
/// on the mirrors.
#[test]
fn what_is_measured_first_leaves_smaller_holes_than_a_grid() {
    let thetas = [0.0, 17.5, 35.0, 52.5, 70.0];
    let (quarter, half) = ([0.0, 30.0, 60.0, 90.0], [0.0, 35.0, 70.0, 105.0, 140.0, 180.0]);
    let round: Vec<f64> = (0..10).map(|k| 36.0 * f64::from(k)).collect();
    let all = [
        (Symmetry::Quadrilateral, &quarter[..]),
        (Symmetry::Bilateral(Mirror::Y), &half[..]),
        (Symmetry::Rotational180, &round[..5]),
        (Symmetry::None, &round[..]),
    ];
    let sides = [Side::Front, Side::Back];
    for ((symmetry, phis), scattered) in all.iter().flat_map(|&a| sides.map(|side| (a, side))) {
        let mut lab: Vec<DVec3> =
            grid(&thetas[1..], phis).iter().map(|&(t, p)| from_degrees(t, p)).collect();
        lab.push(DVec3::Z);
        let limits = Limits { spacing_degrees: 4.0, ..LIMITS };
        let wi =
            begin(symmetry, scattered, &limits, lab.len(), &Watch::default()).expect("directions");
        assert_eq!((wi.len(), wi[0]), (lab.len(), DVec3::Z), "{symmetry}");
        for (k, w) in wi.iter().enumerate() {
            assert!(w.angle_between(DVec3::Z).to_degrees() < 70.0 + 1e-6, "{symmetry} {w}");
            assert!(symmetry.fold(*w).0.distance(*w) < 1e-9, "{symmetry} {w}");
            for (image, v) in
                symmetry.images().iter().flat_map(|i| wi[..k].iter().map(move |v| (i, v)))
            {
                let apart = image.apply(*v).angle_between(*w).to_degrees();
                assert!(apart > 3.99, "{symmetry} {v} {w}: {apart}");
            }
        }
        let apart = |v: DVec3, w: DVec3| match scattered {
            Side::Front => v.angle_between(w),
            Side::Back => v.truncate().distance(w.truncate()),
        };
        let [ours, grids] = [&wi, &lab].map(|all| largest_hole(symmetry, all, apart));
        assert!(ours < grids, "{symmetry} {scattered:?}: {ours}, grid {grids}");
    }
    // Of transmitted light they are as far apart in the disk everywhere, of reflected light denser toward grazing.
    for (symmetry, phis) in all {
        let count = 1 + (thetas.len() - 1) * phis.len();
        let hole = |scattered: Side| {
            let limits = Limits { spacing_degrees: 4.0, ..LIMITS };
            let wi = begin(symmetry, scattered, &limits, count, &Watch::default());
            let apart = |v: DVec3, w: DVec3| v.truncate().distance(w.truncate());
            largest_hole(symmetry, &wi.expect("directions"), apart)
        };
        let (front, back) = (hole(Side::Front), hole(Side::Back));
        assert!(back < front, "{symmetry}: {back} in the disk, of reflected light {front}");
    }
    // On a chain the normal is halfway between a direction and its image.
    let chain =
        begin(Symmetry::Isotropic, Side::Front, &LIMITS, 4, &Watch::default()).expect("directions");
    let mut thetas: Vec<f64> = chain.iter().map(|&w| to_degrees(w).0).collect();
    thetas.sort_by(f64::total_cmp);
    assert!(thetas[0] > 5.0 && thetas[0] < 30.0 && thetas[3] > 60.0, "{thetas:?}");
    assert!(thetas[3] - thetas[2] < thetas[1] - thetas[0], "denser toward grazing: {thetas:?}");
    assert_eq!(
        begin(Symmetry::None, Side::Front, &LIMITS, 0, &Watch::default()).expect("none"),
        []
    );
    let wrong = Limits { max_theta_degrees: f64::NAN, ..LIMITS };
    let error =
        begin(Symmetry::None, Side::Front, &wrong, 3, &Watch::default()).expect_err("refused");
    assert!(error.to_string().contains("largest theta"), "{error}");
}

#[test]
fn no_more_is_proposed_than_there_is_room_for() {
    let known = Known::of(&metal(), Frame::Half);
    let wide = Limits { max_theta_degrees: 60.0, spacing_degrees: 20.0 };
    assert!(known.propose(&wide, 50).len() < 10);
}

#[test]
fn impossible_requests_are_refused() {
    let known = Known::of(&metal(), Frame::Half);
    let refused = |subjects: &[Subject<'_>], limits: &Limits| {
        propose(subjects, limits, 2, &Watch::default()).expect_err("refused")
    };
    let error = refused(&[], &LIMITS);
    assert!(error.to_string().contains("at least one component"), "{error}");
    for (limits, name) in [
        (Limits { max_theta_degrees: 95.0, ..LIMITS }, "largest theta: expected 1 to 89.9"),
        (Limits { max_theta_degrees: f64::NAN, ..LIMITS }, "largest theta"),
        (Limits { spacing_degrees: 0.0, ..LIMITS }, "spacing: expected 0.1 to 45"),
    ] {
        let error = refused(&[known.subject()], &limits);
        assert_eq!(error.class(), ErrorClass::Argument);
        assert!(error.to_string().contains(name), "{error}");
    }
    let fitted = Fitted { incident: Side::Back, ..known.component.fitted().clone() };
    let back = Component::new(fitted, known.component.motion()).expect("component");
    let other = Subject { component: &back, ..known.subject() };
    let error = refused(&[known.subject(), other], &LIMITS);
    assert!(error.to_string().contains("lit from one side"), "{error}");
    let cancel = AtomicBool::new(true);
    let watch = Watch { progress: None, cancel: Some(&cancel) };
    let error = propose(&[known.subject()], &LIMITS, 2, &watch).expect_err("cancelled");
    assert_eq!(error.class(), ErrorClass::Limit);
}
