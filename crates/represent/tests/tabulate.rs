//! Tabulation against closed forms and slow quadrature.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use bsdfkit::matrix::KlemsBasis;
use bsdfkit::tree::{Rank, TensorTree, TreeDistribution};
use bsdfkit::{Distribution, ErrorClass, Sense, Xyz};
use bsdfkit_represent::tabulate::{
    Form, KlemsSettings, Reciprocity, TreeSettings, component, disagreement, klems_matrix,
    tensor_tree,
};
use bsdfkit_represent::{Peak, Slice, Source, Watch};
use bsdfkit_simulate::Material;
use bsdfkit_simulate::material::{BrushedMetal, Fabric};
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::sequence::{plastic_from, quintic};
use bsdfkit_sphere::{DVec2, DVec3, Side};

/// A reflecting material given by its formula.
struct Formula<F> {
    isotropic: bool,
    f: F,
    /// σ of a peak in the mirror direction that slices tell of.
    peak: Option<f64>,
}

struct At<'a, F> {
    formula: &'a Formula<F>,
    wi: DVec3,
}

impl<F: Fn(DVec3, DVec3) -> f64 + Sync> Source for Formula<F> {
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
        Box::new(At { formula: self, wi })
    }
}

impl<F: Fn(DVec3, DVec3) -> f64 + Sync> Slice for At<'_, F> {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (value, &wo) in out.iter_mut().zip(wo) {
            *value = (self.formula.f)(self.wi, wo) as f32;
        }
    }
    fn peaks(&self, out: &mut Vec<Peak>) {
        let direction = DVec3::new(-self.wi.x, -self.wi.y, self.wi.z);
        out.extend(self.formula.peak.map(|radius| Peak { direction, radius }));
    }
}

/// A Gaussian of standard deviation `sigma` in the projected disk about the mirror direction, and a
/// floor.
fn gaussian(sigma: f64) -> impl Fn(DVec3, DVec3) -> f64 {
    move |wi, wo| {
        let q = (wi + wo).truncate().length_squared();
        0.8 * (-q / (2.0 * sigma * sigma)).exp() / (2.0 * PI * sigma * sigma) + 0.05 / PI
    }
}

/// Points of a sequence that is even over the square.
fn even(n: usize) -> impl Iterator<Item = DVec2> {
    (1..=n).map(|k| plastic_from(DVec2::splat(0.3), k))
}

/// Mean L1 over incidences that the tree has not seen, and the ratio of total fluxes.
fn measured<F: Fn(DVec3, DVec3) -> f64>(tree: TensorTree, f: F) -> (f64, f64) {
    let tree = TreeDistribution::new(tree);
    let (mut l1, mut flux, mut truth) = (0.0, 0.0, 0.0);
    let incidences = 100;
    for point in even(incidences) {
        let wi = square_to_hemisphere(point, Side::Front);
        let (mut wrong, mut own, mut all) = (0.0, 0.0, 0.0);
        for scattered in even(5000) {
            let wo = square_to_hemisphere(scattered, Side::Front);
            let (v, t) = (tree.value(wi, wo), f(wi, wo));
            assert!(v >= 0.0 && v.is_finite());
            wrong += (v - t).abs();
            own += v;
            all += t;
        }
        l1 += wrong / all / incidences as f64;
        flux += own;
        truth += all;
    }
    (l1, flux / truth)
}

fn settings() -> TreeSettings {
    TreeSettings { max_samples: Some(6_000_000), ..TreeSettings::default() }
}

#[test]
fn a_lambertian_is_one_leaf() {
    for isotropic in [false, true] {
        let source = Formula { isotropic, f: |_, _| 0.5 / PI, peak: None };
        let (tree, report) = tensor_tree(&source, &settings(), &Watch::default()).unwrap();
        assert_eq!((tree.leaf_count(), report.leaves), (1, 1));
        assert_eq!(report.error, 0.0);
        let value = TreeDistribution::new(tree).value(DVec3::Z, DVec3::Z);
        assert!((value - 0.5 / PI).abs() < 1e-7);
    }
}

#[test]
fn the_stated_error_is_the_measured_one_within_the_budget_and_flux_is_kept() {
    for (rank, leaves) in [(Rank::Three, 20_000), (Rank::Four, 300_000)] {
        for sigma in [0.06, 0.2] {
            let source = Formula { isotropic: true, f: gaussian(sigma), peak: None };
            let settings =
                TreeSettings { rank: Some(rank), max_leaves: Some(leaves), ..settings() };
            let (tree, report) = tensor_tree(&source, &settings, &Watch::default()).unwrap();
            assert!(tree.leaf_count() <= leaves && tree.leaf_count() == report.leaves);
            assert!(tree.leaf_count() > leaves * 9 / 10, "the budget is used");
            let (l1, flux) = measured(tree, gaussian(sigma));
            println!(
                "{rank:?} {sigma}: stated {:.4}, measured {l1:.4}, flux {flux:.5}",
                report.error
            );
            assert!(
                (l1 / report.error - 1.0).abs() < 0.2,
                "stated {}, measured {l1}",
                report.error
            );
            assert!((flux - 1.0).abs() < 4e-3, "{flux}");
        }
    }
}

#[test]
fn a_largest_error_is_honoured_by_the_smallest_tree() {
    let source = Formula { isotropic: true, f: gaussian(0.3), peak: None };
    let of = |max_error| {
        let settings = TreeSettings { max_error, ..settings() };
        tensor_tree(&source, &settings, &Watch::default()).unwrap().1
    };
    let (coarse, fine) = (of(0.2), of(0.1));
    assert!(coarse.error <= 0.2 && coarse.error > 0.17, "{coarse:?}");
    assert!(fine.error <= 0.1 && fine.error > 0.085, "{fine:?}");
    assert!(coarse.leaves < fine.leaves);
}

/// Integrated at incidences that tabulation has not seen.
#[test]
fn a_largest_error_holds_for_materials() {
    let (metal, fabric) = (BrushedMetal::default(), Fabric::default());
    let materials: [(&(dyn Material + Sync), f64); 2] = [(&metal, 0.4), (&fabric, 0.12)];
    for (material, max_error) in materials {
        let f = |wi, wo| material.eval(wi, wo);
        let source = Formula { isotropic: false, f, peak: None };
        let settings = TreeSettings { max_error, ..settings() };
        let (tree, report) = tensor_tree(&source, &settings, &Watch::default()).unwrap();
        assert!(report.error <= max_error && report.leaves < 1_400_000, "{report:?}");
        let (l1, flux) = measured(tree, f);
        println!("asked {max_error}, stated {:.4}, measured {l1:.4}, flux {flux:.5}", report.error);
        assert!(l1 <= 1.15 * max_error && l1 > 0.7 * max_error, "asked {max_error}, measured {l1}");
        assert!((flux - 1.0).abs() < 0.01, "{flux}");
    }
}

/// Where incidences differ in how much they scatter, and in nothing else, the total is off as much as values are: at some
/// more than at others, so that its root mean square is above the mean.
#[test]
fn a_largest_error_holds_for_the_light_of_an_incidence_as_a_whole() {
    let total = |wi: DVec3| 0.1 + 0.8 * (1.0 - wi.z).powi(5);
    let source = Formula { isotropic: true, f: |wi, _| total(wi) / PI, peak: None };
    let settings = TreeSettings { max_error: 0.05, ..settings() };
    let (tree, report) = tensor_tree(&source, &settings, &Watch::default()).unwrap();
    assert!(report.missed.is_none() && report.energy_error <= 0.05, "{report:?}");
    // It was the light that needed the leaves.
    assert!(report.error < 0.04 && report.energy_error > 0.02, "{report:?}");
    let tree = TreeDistribution::new(tree);
    let off = |point| {
        let wi = square_to_hemisphere(point, Side::Front);
        (tree.total(wi, Sense::Forward, 0.0) / total(wi) - 1.0).powi(2)
    };
    let rms = (even(2000).map(off).sum::<f64>() / 2000.0).sqrt();
    // At points, where cells have means.
    assert!(rms <= 1.5 * 0.05, "{rms}: {report:?}");
}

#[test]
fn trees_grow_deeper_where_values_are_left() {
    let source = Formula { isotropic: true, f: gaussian(0.02), peak: Some(0.02) };
    let of = |max_leaves, max_depth| {
        let settings =
            TreeSettings { max_error: 0.0, max_leaves, max_depth, ..TreeSettings::default() };
        tensor_tree(&source, &settings, &Watch::default()).unwrap()
    };
    assert_eq!(of(None, None).0.depth(), 9);
    let (usual, deeper) = (of(Some(3_000_000), Some(9)), of(Some(3_000_000), None));
    assert_eq!((usual.0.depth(), deeper.0.depth()), (9, 10));
    assert!(deeper.1.error < 0.8 * usual.1.error, "{:?} {:?}", usual.1, deeper.1);
    // With as many values, more depth does no harm.
    let (usual, deeper) = (of(Some(40_000), Some(8)), of(Some(40_000), Some(9)));
    assert!(deeper.1.error < 1.05 * usual.1.error, "{:?} {:?}", usual.1, deeper.1);
}

#[test]
fn depth_is_honoured() {
    let source = Formula { isotropic: false, f: gaussian(0.1), peak: None };
    for depth in [0, 2, 5] {
        let settings = TreeSettings { max_depth: Some(depth), ..settings() };
        let (tree, _) = tensor_tree(&source, &settings, &Watch::default()).unwrap();
        assert_eq!(tree.depth(), depth);
    }
}

#[test]
fn leaves_are_means_over_both_cells() {
    // At depth 2 every leaf is larger than the peak; its value by slow quadrature over one 4-D
    // cell.
    let f = gaussian(0.1);
    let source = Formula { isotropic: false, f: gaussian(0.1), peak: None };
    let settings = TreeSettings { max_depth: Some(2), max_error: 0.0, ..TreeSettings::default() };
    let (tree, _) = tensor_tree(&source, &settings, &Watch::default()).unwrap();
    let tree = TreeDistribution::new(tree);
    for (i, o) in [((1, 2), (1, 2)), ((0, 1), (1, 1)), ((3, 3), (3, 3))] {
        let n = 16;
        let at = |cell: (i32, i32), k: i32| {
            let part = DVec2::new((k % n).into(), (k / n).into()) + 0.5;
            (DVec2::new(cell.0.into(), cell.1.into()) + part / f64::from(n)) / 4.0
        };
        // Incident squares are of travel directions: point reflection.
        let incident = |k| square_to_hemisphere(1.0 - at(i, k), Side::Front);
        let mut sum = 0.0;
        for a in 0..n * n {
            let wi = incident(a);
            for b in 0..n * n {
                sum += f(wi, square_to_hemisphere(at(o, b), Side::Front));
            }
        }
        let truth = sum / f64::from(n).powi(4);
        let value =
            tree.value(incident(n * n / 2 + 3), square_to_hemisphere(at(o, 5), Side::Front));
        assert!((value / truth - 1.0).abs() < 0.01, "{i:?} {o:?}: {value}, expected {truth}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_tree() {
    let source = Formula { isotropic: false, f: gaussian(0.1), peak: None };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = TreeSettings { max_leaves: Some(100_000), ..settings() };
        pool.install(|| tensor_tree(&source, &settings, &Watch::default()).unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn rubbish_counts_as_nothing() {
    let f = |wi: DVec3, wo: DVec3| match (10.0 * (wi.x + wo.y)).floor() as i32 % 4 {
        0 => f64::NAN,
        1 => -3.0,
        2 => f64::INFINITY,
        _ => 0.2,
    };
    let source = Formula { isotropic: false, f, peak: None };
    let settings = TreeSettings { max_leaves: Some(20_000), ..settings() };
    // The builder refuses what is negative or not finite.
    tensor_tree(&source, &settings, &Watch::default()).unwrap();
    klems_matrix(&source, &KlemsBasis::quarter(), &KlemsSettings::default(), &Watch::default())
        .unwrap();
}

#[test]
fn reciprocity_is_found_refused_and_made() {
    let reciprocal = Formula { isotropic: false, f: gaussian(0.2), peak: None };
    assert!(disagreement(&reciprocal).unwrap() < 1e-6);
    let skew =
        Formula { isotropic: false, f: |wi: DVec3, _: DVec3| 0.1 + 0.2 * wi.x * wi.x, peak: None };
    assert!(disagreement(&skew).unwrap() > 0.05);
    let of = |reciprocity| {
        let settings = TreeSettings { reciprocity, max_error: 0.005, ..settings() };
        tensor_tree(&skew, &settings, &Watch::default()).unwrap()
    };
    assert!(!of(Reciprocity::Auto).1.reciprocity);
    let tree = TreeDistribution::new(of(Reciprocity::On).0);
    for (a, b) in even(200).zip(even(400).skip(200)) {
        let (a, b) = (square_to_hemisphere(a, Side::Front), square_to_hemisphere(b, Side::Front));
        let mean = 0.1 + 0.1 * (a.x * a.x + b.x * b.x);
        assert!((tree.value(a, b) - mean).abs() < 0.02, "{} for {mean}", tree.value(a, b));
    }
}

/// L1 of row `i` of a matrix against slow quadrature over both patches, and the ratio of fluxes.
fn row_error(
    basis: &KlemsBasis,
    values: &[f32],
    i: usize,
    f: &impl Fn(DVec3, DVec3) -> f64,
) -> (f64, f64) {
    let n = basis.directions();
    let (incident, scattered) = (1500, 100);
    let (mut wrong, mut flux, mut own) = (0.0, 0.0, 0.0);
    for o in 0..n {
        let mut sum = 0.0;
        for k in 1..=incident {
            let [x, y, z, w] = quintic(k);
            let travel = basis.direction_in(i, DVec2::new(x, y));
            let wi = DVec3::new(-travel.x, -travel.y, travel.z);
            let shift = DVec2::new(z, w);
            for b in even(scattered) {
                sum += f(wi, basis.direction_in(o, (b + shift).fract()));
            }
        }
        let truth = sum / f64::from(incident as u32 * scattered as u32);
        let omega = basis.projected_solid_angle(o);
        let value = f64::from(values[i * n + o]);
        wrong += omega * (truth - value).abs();
        flux += omega * truth;
        own += omega * value;
    }
    (wrong / flux, own / flux)
}

#[test]
fn klems_values_are_means_over_both_patches() {
    // The narrowest has σ = 1.5°, a sixth of a patch of the full basis, and would be missed
    // without hints.
    for (basis, sigma, hint, rows, least) in [
        (KlemsBasis::quarter(), 0.1, false, [0, 4, 40], 0.02),
        (KlemsBasis::half(), 0.05, true, [0, 4, 30], 0.015),
        (KlemsBasis::full(), 0.026, true, [0, 60, 120], 0.015),
    ] {
        for isotropic in [true, false] {
            let peak = hint.then_some(sigma);
            let source = Formula { isotropic, f: gaussian(sigma), peak };
            let matrix =
                klems_matrix(&source, &basis, &KlemsSettings::default(), &Watch::default())
                    .unwrap()
                    .0;
            assert_eq!(matrix.values().len(), basis.directions().pow(2));
            for i in rows {
                let (l1, flux) = row_error(&basis, matrix.values(), i, &gaussian(sigma));
                println!("{} {isotropic} row {i}: L1 {l1:.4}, flux {flux:.4}", basis.name());
                assert!(l1 < least, "{} {isotropic} row {i}: {l1}", basis.name());
                assert!((flux - 1.0).abs() < least, "{} {isotropic} row {i}: {flux}", basis.name());
            }
        }
    }
}

/// Where a peak is wider than patches a few samples in each do, if together they lie about its middle.
#[test]
fn a_wide_peak_keeps_its_flux_in_a_klems_matrix() {
    let turned = |wi: DVec3, wo: DVec3| gaussian(0.15)(wi - DVec3::new(0.0, 0.2, 0.0), wo);
    let source = Formula { isotropic: false, f: turned, peak: Some(0.15) };
    let basis = KlemsBasis::full();
    let (matrix, _) =
        klems_matrix(&source, &basis, &KlemsSettings::default(), &Watch::default()).unwrap();
    for i in [0, 6, 18] {
        let (l1, flux) = row_error(&basis, matrix.values(), i, &turned);
        println!("row {i}: L1 {l1:.4}, flux {flux:.4}");
        assert!(l1 < 0.015 && (flux - 1.0).abs() < 0.005, "row {i}: {l1}, {flux}");
    }
}

#[test]
fn a_narrow_mirror_lies_on_the_diagonal() {
    let f = gaussian(0.004);
    let source = Formula { isotropic: false, f: gaussian(0.004), peak: Some(0.004) };
    let basis = KlemsBasis::half();
    let n = basis.directions();
    assert_eq!(n, 77);
    let matrix =
        klems_matrix(&source, &basis, &KlemsSettings::default(), &Watch::default()).unwrap().0;
    for i in 0..n {
        let row = &matrix.values()[i * n..(i + 1) * n];
        let share = |o: usize| f64::from(row[o]) * basis.projected_solid_angle(o);
        // Of 0.85 in all, the floor has 0.05 and the patch's neighbours a rim of its own width.
        assert!(share(i) > 0.55, "row {i}: {}", share(i));
    }
    let settings = TreeSettings { max_depth: Some(4), max_error: 0.0, ..settings() };
    let tree = tensor_tree(&source, &settings, &Watch::default()).unwrap().0;
    let tree = TreeDistribution::new(tree);
    for point in even(50).map(|p| 0.1 + 0.8 * p) {
        let wi = square_to_hemisphere(point, Side::Front);
        let mirror = DVec3::new(-wi.x, -wi.y, wi.z);
        assert!(tree.value(wi, mirror) > 20.0 * f(wi, DVec3::new(-wi.y, wi.x, wi.z)), "{wi}");
    }
}

#[test]
fn a_step_is_found() {
    // Scattered light in half of the hemisphere only, from half of the incidences only.
    let f = |wi: DVec3, wo: DVec3| if wo.x > 0.13 && wi.y < -0.21 { 1.0 / PI } else { 0.0 };
    let source = Formula { isotropic: false, f, peak: None };
    let tree = tensor_tree(&source, &settings(), &Watch::default()).unwrap().0;
    let tree = TreeDistribution::new(tree);
    let (mut wrong, mut sum) = (0.0, 0.0);
    for (a, b) in even(3000).zip(even(7000).skip(4000)) {
        let (a, b) = (square_to_hemisphere(a, Side::Front), square_to_hemisphere(b, Side::Front));
        wrong += (tree.value(a, b) - f(a, b)).abs();
        sum += f(a, b);
    }
    println!("step: L1 {:.4}", wrong / sum);
    assert!(wrong < 0.05 * sum, "{}", wrong / sum);
}

#[test]
fn ranks_of_the_same_isotropic_source_agree() {
    let source = Formula { isotropic: true, f: gaussian(0.3), peak: None };
    let of = |rank| {
        let settings = TreeSettings { rank: Some(rank), max_error: 0.03, ..settings() };
        TreeDistribution::new(tensor_tree(&source, &settings, &Watch::default()).unwrap().0)
    };
    let (three, four) = (of(Rank::Three), of(Rank::Four));
    let (mut wrong, mut sum) = (0.0, 0.0);
    for (a, b) in even(4000).zip(even(8000).skip(4000)) {
        let (a, b) = (square_to_hemisphere(a, Side::Front), square_to_hemisphere(b, Side::Front));
        wrong += (three.value(a, b) - four.value(a, b)).abs();
        sum += three.value(a, b);
    }
    println!("ranks: L1 {:.4}", wrong / sum);
    assert!(wrong < 0.12 * sum, "{}", wrong / sum);
}

/// f of luminance in another colour on each side of the mirror plane.
struct Coloured;

impl Source for Coloured {
    fn incident(&self) -> Side {
        Side::Front
    }
    fn scattered(&self) -> Side {
        Side::Front
    }
    fn isotropic(&self) -> bool {
        false
    }
    fn channels(&self) -> usize {
        3
    }
    fn slice<'a>(&'a self, _: DVec3) -> Box<dyn Slice + 'a> {
        Box::new(Coloured)
    }
}

impl Slice for Coloured {
    fn eval(&self, wo: &[DVec3], out: &mut [f32]) {
        for (out, w) in out.chunks_exact_mut(3).zip(wo) {
            let [x, z] = if w.y > 0.0 { [0.9, 0.4] } else { [1.2, 0.1] };
            out.copy_from_slice(&[0.1 + 0.1 * w.x.abs() as f32, 0.1 * x, 0.1 * z]);
        }
    }
}

#[test]
fn three_channels_make_colour_in_trees_and_matrices() {
    let wi = DVec3::new(0.3, 0.2, 0.9).normalize();
    for form in [
        Form::Tree(TreeSettings {
            max_error: 0.02,
            reciprocity: Reciprocity::Off,
            ..TreeSettings::default()
        }),
        Form::Klems(KlemsBasis::full(), KlemsSettings::default()),
    ] {
        let made = component(&Coloured, &form, &Watch::default()).unwrap();
        assert!(made.component.distribution().is_coloured());
        for wo in [DVec3::new(0.02, 0.5, 0.8), DVec3::new(0.4, -0.5, 0.7)] {
            let wo = wo.normalize();
            let mut truth = [0.0f32; 3];
            Coloured.eval(&[wo], &mut truth);
            let [y, x, z] = truth.map(f64::from);
            let value = made.component.distribution().value_xyz(wi, wo);
            assert!((value.y - y).abs() < 0.1 * y, "{form:?} {wo}: {value:?}, expected {truth:?}");
            let ((u, v), (u_true, v_true)) = (value.uv(), Xyz::new(x, y, z).uv());
            let off = (u - u_true).hypot(v - v_true);
            assert!(off < 0.006, "{form:?} {wo}: {off}: {value:?}, expected {truth:?}");
        }
    }
}

#[test]
fn rank_three_is_averaged_over_exchange() {
    // f depends on the incident polar angle only; its mean with the exchange on both.
    let f = |wi: DVec3, _: DVec3| 0.1 + 0.2 * (1.0 - wi.z * wi.z);
    let source = Formula { isotropic: true, f, peak: None };
    let settings =
        TreeSettings { reciprocity: Reciprocity::On, max_error: 0.005, ..TreeSettings::default() };
    let (tree, report) = tensor_tree(&source, &settings, &Watch::default()).unwrap();
    assert!(report.reciprocity);
    assert_eq!(tree.rank(), Rank::Three);
    let tree = TreeDistribution::new(tree);
    for (a, b) in even(200).zip(even(400).skip(200)) {
        let (a, b) = (square_to_hemisphere(a, Side::Front), square_to_hemisphere(b, Side::Front));
        let mean = 0.5 * (f(a, b) + f(b, a));
        assert!((tree.value(a, b) - mean).abs() < 0.02, "{} for {mean}", tree.value(a, b));
    }
    // A peak's exchange is the peak: averaging must not move it.
    let f = gaussian(0.15);
    let source = Formula { isotropic: true, f: gaussian(0.15), peak: None };
    let (tree, _) = tensor_tree(&source, &settings, &Watch::default()).unwrap();
    let (l1, flux) = measured(tree, &f);
    assert!(l1 < 0.08 && (flux - 1.0).abs() < 5e-3, "{l1} {flux}");
}

#[test]
fn settings_and_cancellation_are_checked() {
    let source = Formula { isotropic: false, f: gaussian(0.2), peak: None };
    let class = |settings: TreeSettings| {
        tensor_tree(&source, &settings, &Watch::default()).unwrap_err().class()
    };
    assert_eq!(class(TreeSettings { rank: Some(Rank::Three), ..settings() }), ErrorClass::Argument);
    assert_eq!(class(TreeSettings { max_error: f64::NAN, ..settings() }), ErrorClass::Argument);
    assert_eq!(class(TreeSettings { max_depth: Some(99), ..settings() }), ErrorClass::Limit);
    let (stop, taken) = (AtomicBool::new(true), AtomicUsize::new(0));
    let counted = |wi: DVec3, wo: DVec3| {
        taken.fetch_add(1, Ordering::Relaxed);
        gaussian(0.2)(wi, wo)
    };
    let source = Formula { isotropic: false, f: counted, peak: None };
    let watch = Watch { cancel: Some(&stop), ..Watch::default() };
    assert_eq!(tensor_tree(&source, &settings(), &watch).unwrap_err().class(), ErrorClass::Limit);
    // Only a look at peaks comes before.
    let taken = taken.into_inner();
    assert!(taken < 2000, "{taken} values taken after it was cancelled");
}
