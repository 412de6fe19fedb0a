//! Conversions of stored BSDFs against closed forms and slow quadrature.

use std::f64::consts::PI;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix, Ring};
use bsdfkit::tree::{Rank, TensorTree, TreeBuilder, TreeDistribution};
use bsdfkit::{Component, Distribution, ErrorClass, Sense};
use bsdfkit_represent::tabulate::{
    Form, KlemsSettings, Limit, Reciprocity, Report, TreeReport, TreeSettings, component,
    reciprocal, stored,
};
use bsdfkit_represent::{Slice, Source, Watch};
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::sequence::plastic_from;
use bsdfkit_sphere::{DVec2, DVec3, Side};

const SIDES: [Side; 2] = [Side::Front, Side::Back];

fn custom() -> KlemsBasis {
    let rings = [(12.0, 1), (33.0, 6), (58.0, 10), (90.0, 14)];
    let ring = |(upper_degrees, patches)| Ring { upper_degrees, patches };
    KlemsBasis::new("custom", rings.map(ring).to_vec()).unwrap()
}

/// Nothing beyond 70 degrees.
fn incomplete() -> KlemsBasis {
    let rings = [(20.0, 1), (70.0, 9)];
    let ring = |(upper_degrees, patches)| Ring { upper_degrees, patches };
    KlemsBasis::new("incomplete", rings.map(ring).to_vec()).unwrap()
}

fn matrix(basis: &KlemsBasis, f: impl Fn(usize, usize) -> f64) -> KlemsMatrix {
    let n = basis.directions();
    let values = (0..n * n).map(|k| f(k / n, k % n) as f32).collect();
    KlemsMatrix::new(basis.clone(), basis.clone(), values).unwrap()
}

/// Rows of one value each: ρ/π, ρ from .56 to .71 and not reciprocal.
fn lambertian(basis: &KlemsBasis) -> KlemsMatrix {
    matrix(basis, |i, _| albedo(basis, i) / PI)
}

fn albedo(basis: &KlemsBasis, i: usize) -> f64 {
    0.56 + 0.15 * basis.centre(i).truncate().length_squared()
}

/// Straight through with a haze.
fn through(basis: &KlemsBasis) -> KlemsMatrix {
    matrix(basis, |i, o| 0.1 / PI + if i == o { 0.7 / basis.projected_solid_angle(i) } else { 0.0 })
}

/// Different everywhere.
fn uneven(basis: &KlemsBasis) -> KlemsMatrix {
    matrix(basis, |i, o| ((7 * i + 3 * o) % 11) as f64 / 10.0)
}

/// Points of a sequence that is even over the square.
fn even(n: usize) -> impl Iterator<Item = DVec2> {
    (1..=n).map(|k| plastic_from(DVec2::splat(0.3), k))
}

/// An incident direction that travels to a place of the square, and a scattered one.
fn at(incident: DVec2, scattered: DVec2) -> (DVec3, DVec3) {
    let travel = square_to_hemisphere(incident, Side::Front);
    (DVec3::new(-travel.x, -travel.y, travel.z), square_to_hemisphere(scattered, Side::Front))
}

fn tree_settings() -> TreeSettings {
    TreeSettings { rank: Some(Rank::Four), ..TreeSettings::default() }
}

fn to_tree(from: &Component, settings: TreeSettings) -> (Component, TreeReport) {
    let made = stored(from, &Form::Tree(settings), &Watch::default()).unwrap();
    let Report::Tree(report) = made.report else { panic!("{:?}", made.report) };
    assert_eq!(
        (made.component.incident, made.component.scattered),
        (from.incident, from.scattered)
    );
    assert_eq!(luminance(&made.component).leaf_count(), report.leaves);
    (made.component, report)
}

fn to_matrix(from: &Component, basis: &KlemsBasis) -> Component {
    let form = Form::Klems(basis.clone(), KlemsSettings::default());
    stored(from, &form, &Watch::default()).unwrap().component
}

fn front(distribution: impl Distribution) -> Component {
    Component::new(Side::Front, Side::Front, distribution)
}

fn luminance(of: &Component) -> &TensorTree {
    of.distribution().downcast_ref::<TreeDistribution>().unwrap().luminance()
}

fn total(of: &Component, wi: DVec3) -> f64 {
    of.distribution().total(wi, Sense::Forward, 0.0)
}

/// ∫∫ f over both hemispheres, from totals at `n` incidences.
fn energy(of: &Component, n: usize) -> f64 {
    let wi = |p| at(p, DVec2::splat(0.5)).0;
    even(n).map(|p| total(of, wi(p))).sum::<f64>() / n as f64
}

/// L1 of `to` as a share of each incidence's flux, mean over incidences, by points.
fn l1(from: &Component, to: &Component) -> f64 {
    let (mut sum, incidences, points) = (0.0, 5000, 400);
    for p in even(incidences) {
        let flux = total(from, at(p, DVec2::splat(0.5)).0);
        for q in even(points) {
            let (wi, wo) = at(p, q);
            let off = from.distribution().value(wi, wo) - to.distribution().value(wi, wo);
            sum += off.abs() * PI / flux;
        }
    }
    sum / (incidences * points) as f64
}

#[test]
fn matrices_keep_totals_of_every_patch_on_other_bases() {
    for (from, to) in [
        (KlemsBasis::full(), KlemsBasis::half()),
        (KlemsBasis::full(), KlemsBasis::quarter()),
        (KlemsBasis::quarter(), KlemsBasis::full()),
        (KlemsBasis::half_73(), KlemsBasis::half()),
        (custom(), KlemsBasis::full()),
        (incomplete(), KlemsBasis::half()),
    ] {
        for source in [lambertian(&from), through(&from), uneven(&from)] {
            let source = front(source);
            let made = to_matrix(&source, &to);
            // The mean of the old totals over each new patch, by points of that.
            let n = 40;
            for k in (0..to.directions()).step_by(5) {
                let mut mean = 0.0;
                for p in 0..n * n {
                    let place = DVec2::new((p % n) as f64 + 0.5, (p / n) as f64 + 0.5);
                    let w = to.direction_in(k, place / n as f64);
                    mean += total(&source, DVec3::new(-w.x, -w.y, w.z)) / (n * n) as f64;
                }
                let centre = to.centre(k);
                let own = total(&made, DVec3::new(-centre.x, -centre.y, centre.z));
                assert!(
                    (own - mean).abs() < 0.02 * mean + 1e-6,
                    "{} {k}: {own}, {mean}",
                    from.name()
                );
            }
        }
    }
}

#[test]
fn a_matrix_in_its_own_basis_is_copied_and_colour_stays() {
    let (full, half) = (KlemsBasis::full(), KlemsBasis::half());
    let grey = uneven(&full);
    let scaled = |s: f32| grey.values().iter().map(|v| s * v).collect::<Vec<_>>();
    let (x, z) = (scaled(0.5), scaled(2.0));
    let source = front(grey.with_colour(x, z).unwrap());
    let form = Form::Klems(full, KlemsSettings::default());
    let copied = stored(&source, &form, &Watch::default()).unwrap();
    assert_eq!(copied.report, Report::Copied);
    let made = to_matrix(&source, &half);
    for (p, q) in even(50).zip(even(100).skip(50)) {
        let (wi, wo) = at(p, q);
        let value = made.distribution().value_xyz(wi, wo);
        assert!((value.x - 0.5 * value.y).abs() < 1e-6 && (value.z - 2.0 * value.y).abs() < 1e-6);
    }
}

#[test]
fn a_step_function_becomes_a_tree_whose_stated_error_is_exact() {
    for basis in [KlemsBasis::full(), custom(), incomplete()] {
        for source in [lambertian(&basis), through(&basis), uneven(&basis)] {
            let source = front(source);
            let settings = TreeSettings { max_leaves: Some(60_000), ..tree_settings() };
            let (made, report) = to_tree(&source, settings);
            let measured = match basis.is_complete() {
                true => l1(&source, &made),
                false => report.error,
            };
            println!("{} {:?}, measured {measured:.4}", basis.name(), report);
            assert!((measured - report.error).abs() < 0.05 * report.error + 1e-4);
            let missed = report.missed.map(|missed| missed.limit);
            let full = report.error > 0.01;
            assert_eq!(missed, full.then_some(Limit::Leaves(60_000)));
            // Means of the whole are the same to rounding, and so is the mean of both trees'
            // quarters.
            let exact = luminance_mean(&made);
            let truth = {
                let m = source.distribution().downcast_ref::<KlemsMatrix>().unwrap();
                let omega = |k| basis.projected_solid_angle(k) / PI;
                let n = basis.directions();
                let values = m.values().iter().enumerate();
                values.map(|(k, &v)| f64::from(v) * omega(k / n) * omega(k % n)).sum::<f64>()
            };
            assert!((exact / truth - 1.0).abs() < 1e-6, "{exact} {truth}");
        }
    }
}

fn luminance_mean(of: &Component) -> f64 {
    struct Sum(f64, Vec<f64>);
    impl bsdfkit::tree::TreeVisitor for Sum {
        fn open_branch(&mut self) -> bsdfkit::Result<()> {
            self.1.push(self.1.last().unwrap() / 16.0);
            Ok(())
        }
        fn leaf(&mut self, value: f32) -> bsdfkit::Result<()> {
            self.0 += f64::from(value) * self.1.last().unwrap();
            Ok(())
        }
        fn grid(&mut self, _: u32, values: &[f32]) -> bsdfkit::Result<()> {
            let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
            self.0 += mean * self.1.last().unwrap();
            Ok(())
        }
        fn close_branch(&mut self) -> bsdfkit::Result<()> {
            self.1.pop();
            Ok(())
        }
    }
    let mut sum = Sum(0.0, vec![1.0]);
    luminance(of).visit(&mut sum).unwrap();
    sum.0
}

#[test]
fn no_leaves_where_nothing_varies() {
    let basis = KlemsBasis::full();
    let constant = front(matrix(&basis, |_, _| 0.2));
    assert_eq!(to_tree(&constant, tree_settings()).1.leaves, 1);
    // One pair of patches: leaves at its edges only, and the light stays between them.
    let lone = front(matrix(&basis, |i, o| f64::from(u8::from(i == 40 && o == 60))));
    let (made, report) = to_tree(&lone, TreeSettings { max_error: 0.2, ..tree_settings() });
    println!("{report:?}");
    assert!(report.error <= 0.2 && report.leaves < 60_000, "{report:?}");
    let patch = |w: DVec3| basis.index(w).unwrap();
    for (p, q) in even(3000).zip(even(9000).skip(5000)) {
        let (wi, wo) = at(p, q);
        let (i, o) = (patch(DVec3::new(-wi.x, -wi.y, wi.z)), patch(wo));
        let far = |a: usize, b: usize| {
            basis.centre(a).truncate().distance(basis.centre(b).truncate()) > 0.4
        };
        if far(i, 40) || far(o, 60) {
            assert_eq!(made.distribution().value(wi, wo), 0.0);
        }
    }
}

#[test]
fn totals_are_kept_on_every_side_and_unasked_nothing_is_averaged() {
    let basis = KlemsBasis::full();
    for incident in SIDES {
        for scattered in SIDES {
            let source = Component::new(incident, scattered, lambertian(&basis));
            let (made, report) = to_tree(&source, tree_settings());
            assert!(!report.reciprocity && report.missed.is_none(), "{report:?}");
            for k in 0..basis.directions() {
                let inside = even(400).map(|p| basis.direction_in(k, p));
                let totals = inside.map(|w| total(&made, DVec3::new(-w.x, -w.y, w.z)));
                let (own, truth) = (totals.sum::<f64>() / 400.0, albedo(&basis, k));
                assert!((own / truth - 1.0).abs() < 0.0055, "{k}: {own}, expected {truth}");
            }
            let half = to_matrix(&source, &KlemsBasis::half());
            assert!((energy(&half, 20_000) / energy(&source, 20_000) - 1.0).abs() < 1e-4);
        }
    }
}

#[test]
fn on_request_reciprocal_values_are_averaged() {
    let basis = KlemsBasis::full();
    let source = front(lambertian(&basis));
    let averaged = reciprocal(&source, &Watch::default()).unwrap();
    for (p, q) in even(500).zip(even(1000).skip(500)) {
        let (a, b) = at(p, q);
        let f = |c: &Component, a, b| c.distribution().value(a, b);
        let mean = 0.5 * (f(&source, a, b) + f(&source, b, a));
        assert!(
            (f(&averaged, a, b) - mean).abs() < 1e-6 && (f(&averaged, b, a) - mean).abs() < 1e-6
        );
    }
    assert!((energy(&averaged, 20_000) / energy(&source, 20_000) - 1.0).abs() < 1e-3);
    let settings = TreeSettings { reciprocity: Reciprocity::On, ..tree_settings() };
    let (tree, report) = to_tree(&source, settings);
    assert!(report.reciprocity);
    let normal = total(&tree, DVec3::Z);
    assert!((normal - 0.6).abs() < 0.01, "the mean of .56 and of .56 to .71: {normal}");
    // A tree that is averaged stays a tree.
    let (again, report) = to_tree(&to_tree(&source, tree_settings()).0, settings);
    assert!(report.reciprocity && (total(&again, DVec3::Z) - 0.6).abs() < 0.01);

    let class = |c: &Component| reciprocal(c, &Watch::default()).unwrap_err().class();
    let across = Component::new(Side::Front, Side::Back, lambertian(&basis));
    assert_eq!(class(&across), ErrorClass::Argument);
    let odd = KlemsBasis::new("odd", vec![Ring { upper_degrees: 90.0, patches: 5 }]).unwrap();
    assert_eq!(class(&front(uneven(&odd))), ErrorClass::Argument);
}

#[test]
fn targets_that_are_not_reached_are_named() {
    let source = front(through(&KlemsBasis::full()));
    let words = |settings| to_tree(&source, settings).1.missed.unwrap().to_string();
    let most = TreeSettings { max_leaves: Some(20_000), ..tree_settings() };
    let text = "target L1 0.01 not reached: it takes more than 20000 leaves";
    assert_eq!(words(most), text);
    let flat = TreeSettings { max_depth: Some(2), ..tree_settings() };
    let text = "target L1 0.01 not reached: it takes leaves deeper than level 2";
    assert_eq!(words(flat), text);
    // A tree that is cut says the same.
    let tree = to_tree(&source, TreeSettings { max_leaves: Some(200_000), ..tree_settings() }).0;
    let (cut, report) = to_tree(&tree, most);
    assert!(report.leaves <= 20_000 && report.leaves > 17_000);
    assert_eq!(report.missed.unwrap().limit, Limit::Leaves(20_000));
    let measured = l1(&tree, &cut);
    println!("cut: stated {:.4}, measured {measured:.4}", report.error);
    assert!((measured / report.error - 1.0).abs() < 0.05);
    let copied = stored(&tree, &Form::Tree(tree_settings()), &Watch::default()).unwrap();
    assert_eq!(copied.report, Report::Copied);
}

#[test]
fn what_is_negligible_is_one_leaf() {
    let basis = KlemsBasis::full();
    let faint = |most: f64| {
        matrix(&basis, move |i, o| {
            f64::from(u8::from(i == o)) * most / KlemsBasis::full().projected_solid_angle(i)
        })
    };
    for (source, leaves) in [(faint(0.0), 1), (faint(0.0009), 1), (faint(0.0011), 2)] {
        let settings = TreeSettings { max_leaves: Some(10_000), ..tree_settings() };
        let (made, report) = to_tree(&front(source), settings);
        assert_eq!(report.negligible, leaves == 1);
        assert!(leaves == 1 && report.leaves == 1 || report.leaves > 1000, "{report:?}");
        assert!(report.negligible == report.missed.is_none());
        assert!(
            (energy(&made, 2000) / 0.0009 - 1.0).abs() < 0.3
                || leaves == 1 && energy(&made, 10) < 1e-3
        );
    }
    // The same of a continuous source.
    let source = Peak { isotropic: false, total: 0.0008 };
    let made = component(&source, &Form::Tree(tree_settings()), &Watch::default()).unwrap();
    let Report::Tree(report) = made.report else { panic!() };
    assert!(report.negligible && report.leaves == 1 && report.missed.is_none());
}

/// A peak of σ = 0.1 in the projected disk about the mirror direction.
struct Peak {
    isotropic: bool,
    total: f64,
}

impl Source for Peak {
    fn incident(&self) -> Side {
        Side::Front
    }
    fn scattered(&self) -> Side {
        Side::Front
    }
    fn isotropic(&self) -> bool {
        self.isotropic
    }
    fn slice<'a>(&'a self, wi: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(PeakAt(self.total, wi))
    }
}

struct PeakAt(f64, DVec3);

impl Slice for PeakAt {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (value, w) in out.iter_mut().zip(wo) {
            let q = (self.1 + *w).truncate().length_squared() / 0.02;
            *value = (self.0 * (-q).exp() / (0.02 * PI)) as f32;
        }
    }
}

#[test]
fn an_isotropic_source_beside_anisotropic_ones_has_a_third_of_the_leaves() {
    let source = Peak { isotropic: true, total: 0.8 };
    let made = component(&source, &Form::Tree(tree_settings()), &Watch::default()).unwrap();
    let Report::Tree(report) = made.report else { panic!() };
    println!("{report:?}");
    assert!(report.leaves <= 1_000_000 && report.leaves > 500_000, "{report:?}");
    assert_eq!(report.missed.unwrap().limit, Limit::Leaves(1_000_000));
}

/// Rank 3: f by polar cell (travel radius, grazing first) and scattered quadrant in the plane of
/// incidence.
fn turning_tree() -> TreeDistribution {
    let mut b = TreeBuilder::new(Rank::Three);
    b.open_branch().unwrap();
    for child in 0..8 {
        // Lower half of the first dimension only: bit 0 clear.
        if child & 1 == 1 {
            b.leaf(0.0).unwrap();
            continue;
        }
        b.open_branch().unwrap();
        for inner in 0..8 {
            let polar = inner & 1;
            b.leaf(0.1 + 0.05 * polar as f32 + 0.1 * (child >> 1) as f32).unwrap();
        }
        b.close_branch().unwrap();
    }
    b.close_branch().unwrap();
    TreeDistribution::new(b.finish().unwrap())
}

#[test]
fn trees_of_rank_three_keep_totals_and_turn() {
    let source = front(turning_tree());
    for basis in [KlemsBasis::full(), KlemsBasis::quarter()] {
        let made = to_matrix(&source, &basis);
        let n = basis.directions();
        let values = made.distribution().downcast_ref::<KlemsMatrix>().unwrap().values().to_vec();
        for i in [0, 5, n / 2, n - 3] {
            // By points of both patches.
            // By points of both patches, whose azimuths never agree.
            let inside = |k: usize, p: usize, points: usize| {
                let place = DVec2::new((p % points) as f64 + 0.5, (p / points) as f64 + 0.5);
                basis.direction_in(k, place / points as f64)
            };
            for o in [0, 9, n / 3, n - 1] {
                let mut mean = 0.0;
                for p in 0..23 * 23 {
                    let travel = inside(i, p, 23);
                    let wi = DVec3::new(-travel.x, -travel.y, travel.z);
                    for q in 0..24 * 24 {
                        mean += source.distribution().value(wi, inside(o, q, 24));
                    }
                }
                mean /= (23 * 23 * 24 * 24) as f64;
                let own = f64::from(values[i * n + o]);
                assert!((own / mean - 1.0).abs() < 0.01, "{} {i} {o}: {own}, {mean}", basis.name());
            }
        }
        assert!((energy(&made, 20_000) / energy(&source, 20_000) - 1.0).abs() < 2e-3);
    }
    let (four, report) = to_tree(&source, TreeSettings { max_error: 0.1, ..tree_settings() });
    assert!(report.error <= 0.1 && report.leaves < 1_000_000, "{report:?}");
    assert!((energy(&four, 5000) / energy(&source, 5000) - 1.0).abs() < 2e-3);
    let measured = l1(&source, &four);
    assert!(measured < 0.12, "{measured}");
}

#[test]
fn trees_of_rank_four_become_matrices_exactly() {
    let basis = KlemsBasis::full();
    let source = front(uneven(&basis));
    let settings = TreeSettings { max_leaves: Some(30_000), ..tree_settings() };
    let (tree, _) = to_tree(&source, settings);
    for target in [KlemsBasis::full(), KlemsBasis::quarter()] {
        let made = to_matrix(&tree, &target);
        assert!((energy(&made, 20_000) / luminance_mean(&tree) / PI - 1.0).abs() < 1e-3);
        let n = target.directions();
        let values = made.distribution().downcast_ref::<KlemsMatrix>().unwrap().values().to_vec();
        for (i, o) in [(0, 0), (7, n - 1), (n / 2, n / 3)] {
            let points = 40;
            let inside = |k: usize, p: usize| {
                let place = DVec2::new((p % points) as f64 + 0.5, (p / points) as f64 + 0.5);
                target.direction_in(k, place / points as f64)
            };
            let mut mean = 0.0;
            for p in 0..points * points {
                let travel = inside(i, p);
                let wi = DVec3::new(-travel.x, -travel.y, travel.z);
                for q in (p % 8..points * points).step_by(8) {
                    mean += tree.distribution().value(wi, inside(o, q));
                }
            }
            mean /= (points * points * points * points / 8) as f64;
            let own = f64::from(values[i * n + o]);
            assert!((own / mean - 1.0).abs() < 0.01, "{i} {o}: {own}, {mean}");
        }
    }
}
