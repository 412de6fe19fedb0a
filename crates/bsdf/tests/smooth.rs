//! Smooth lookup: what it keeps of the stored values, and what it gains.

mod support;

use std::f64::consts::PI;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TensorTree, TreeBuilder, TreeDistribution};
use bsdfkit::{
    Bsdf, Component, Components, DVec2, DVec3, Lambertian, Lookup, Metadata, Sense, Side,
    container, xml,
};
use bsdfkit_sphere::concentric::{hemisphere_to_square, square_to_hemisphere};
use support::{Random, random_tree};

fn of(components: Vec<Component>) -> Bsdf {
    Bsdf::new(Metadata::default(), components, Lambertian::default())
}

fn reflection(tree: TensorTree) -> Bsdf {
    of(vec![Component::new(Side::Front, Side::Front, TreeDistribution::new(tree))])
}

fn smooth(bsdf: Bsdf) -> Bsdf {
    bsdf.with_lookup(Lookup::Smooth).unwrap()
}

/// Directions at a point of the tree's hypercube: travel square and scattered square.
fn pair(p: DVec2, q: DVec2) -> (DVec3, DVec3) {
    let front = |s| square_to_hemisphere(s, Side::Front);
    (front(DVec2::ONE - p), front(q))
}

/// A grid of 2^log2 cells a side of f at the cells' centres (p.x, p.y, q.x, q.y).
fn grid(log2: u32, f: impl Fn(DVec2, DVec2) -> f64) -> TensorTree {
    let n = 1_usize << log2;
    let at = |i: usize| (i as f64 + 0.5) / n as f64;
    let values: Vec<f32> = (0..n.pow(4))
        .map(|i| {
            let [px, py, qx, qy] = [3, 2, 1, 0].map(|d| at(i / n.pow(d) % n));
            f(DVec2::new(px, py), DVec2::new(qx, qy)) as f32
        })
        .collect();
    let mut b = TreeBuilder::new(Rank::Four);
    b.grid(log2, &values).unwrap();
    b.finish().unwrap()
}

/// A peak in the mirror direction, about as wide as a cell, across the cell of the most grazing incidences.
#[test]
fn light_at_the_rim_of_incidences_is_kept() {
    let n = 64;
    let at = |i: usize| (i as f64 + 0.5) / n as f64;
    let deviation = 1.2 / n as f64;
    let f = |p: f64, x: f64, y: f64| {
        (-((x - 1.0 + p).powi(2) + (y - 0.5).powi(2)) / (2.0 * deviation * deviation)).exp()
    };
    let values: Vec<f32> =
        (0..n * n * n).map(|i| f(at(i / (n * n)), at(i / n % n), at(i % n)) as f32).collect();
    let mut b = TreeBuilder::new(Rank::Three);
    b.grid(6, &values).unwrap();
    let bsdf = smooth(reflection(b.finish().unwrap()));
    for place in [0.1, 0.5, 0.9] {
        let p = place / n as f64;
        let all = (0..1_000_000)
            .map(|k| f(p, (f64::from(k / 1000) + 0.5) / 1e3, (f64::from(k % 1000) + 0.5) / 1e3));
        let truth = PI * all.sum::<f64>() / 1e6;
        let sin = 1.0 - 2.0 * p;
        let wi = DVec3::new(-sin, 0.0, (1.0 - sin * sin).sqrt());
        let found = bsdf.directional_hemispherical(wi, Components::ALL);
        assert!((found / truth - 1.0).abs() < 0.04, "{place}: {found} {truth}");
    }
}

#[test]
fn constants_stay_constant() {
    let mut b = TreeBuilder::new(Rank::Four);
    b.open_branch().unwrap();
    for child in 0..16 {
        if child % 3 == 0 { b.grid(2, &[2.5; 256]).unwrap() } else { b.leaf(2.5).unwrap() }
    }
    b.close_branch().unwrap();
    let uneven = smooth(reflection(b.finish().unwrap()));
    let whole = smooth(reflection(TensorTree::constant(Rank::Three, 2.5).unwrap()));
    let mut random = Random(1);
    for _ in 0..1000 {
        let (wi, wo) = (random.direction(Side::Front), random.direction(Side::Front));
        for bsdf in [&uneven, &whole] {
            assert_eq!(bsdf.eval(wi, wo), 2.5);
            let total = bsdf.directional_hemispherical(wi, Components::ALL);
            assert!((total - 2.5 * PI).abs() < 1e-12, "{total}");
        }
    }
}

/// Where, from 0 to 1, the two points lie whose mean is that of any quadratic. [Gauss–Legendre]
const NODES: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// The mean over each leaf is the leaf's value, by 2⁴ points.
#[test]
fn leaves_keep_their_means() {
    let tree = random_tree(Rank::Four, 3, 0.03, &mut Random(21));
    let bsdf = smooth(reflection(tree.clone()));
    let mut random = Random(22);
    let mut varied = 0;
    for _ in 0..2000 {
        let x: [f64; 4] = std::array::from_fn(|_| random.unit());
        let directions = |x: [f64; 4]| pair(DVec2::new(x[0], x[1]), DVec2::new(x[2], x[3]));
        let (wi, wo) = directions(x);
        let (value, level) = tree.leaf_at(wi, wo);
        let width = (-f64::from(level)).exp2();
        let values: Vec<f64> = (0..16)
            .map(|corner| {
                let (wi, wo) = directions(std::array::from_fn(|d| {
                    ((x[d] / width).floor() + NODES[corner >> d & 1]) * width
                }));
                bsdf.eval(wi, wo)
            })
            .collect();
        let mean = values.iter().sum::<f64>() / 16.0;
        assert!((mean - f64::from(value)).abs() < 1e-12 * mean, "{mean} {value}");
        assert!(values.iter().all(|v| *v >= 0.03_f32.into()), "{values:?}");
        varied += u32::from(values.iter().any(|v| (v - mean).abs() > 0.1 * mean));
    }
    assert!(varied > 500, "only {varied} leaves vary");
}

/// A ridge along the diagonal, σ = 1.5 cells: less than a quarter of the stored values' error, and the
/// steps between neighbouring leaves less than a third of theirs.
#[test]
fn a_ridge_is_followed() {
    let ridge = |p: DVec2, q: DVec2| {
        let background = 0.1 + 0.2 * q.x * p.y;
        background + 3.0 * (-(q - p).length_squared() / (2.0 * 0.094 * 0.094)).exp()
    };
    let stored = reflection(grid(4, ridge));
    let smooth = smooth(stored.clone());
    let mut random = Random(31);
    let (mut light, mut errors, mut steps) = (0.0, [0.0; 2], [0.0; 2]);
    for _ in 0..100_000 {
        let mut unit = || DVec2::new(random.unit(), random.unit());
        let (p, q) = (0.2 + 0.6 * unit(), unit());
        let (wi, wo) = pair(p, q);
        light += ridge(p, q);
        let border = (q.x * 16.0).round() / 16.0;
        let beside = |dx: f64| pair(p, DVec2::new((border + dx).clamp(0.0, 1.0), q.y)).1;
        for (i, bsdf) in [&stored, &smooth].into_iter().enumerate() {
            errors[i] += (bsdf.eval(wi, wo) - ridge(p, q)).abs();
            steps[i] += (bsdf.eval(wi, beside(1e-9)) - bsdf.eval(wi, beside(-1e-9))).abs();
        }
    }
    assert!(errors[1] < 0.25 * errors[0], "{:?}", errors.map(|e| e / light));
    assert!(steps[1] < 0.33 * steps[0], "{:?}", steps.map(|s| s / light));
}

/// A leaf is large because little varies in it: a peak in its neighbour does not make it rise, unless it
/// borders on the leaf.
#[test]
fn large_leaves_see_what_borders_on_them() {
    let rise = |peak: usize| {
        let mut b = TreeBuilder::new(Rank::Four);
        b.open_branch().unwrap();
        for child in 0..16 {
            if child & 4 == 0 {
                // 8 cells across, along x of the scattered square one is bright. The others are twice as bright as the
                // darkest leaf.
                let values: Vec<f32> =
                    (0..4096).map(|i| if i / 8 % 8 == peak { 200.0 } else { 2.0 }).collect();
                b.grid(3, &values).unwrap();
            } else {
                b.leaf(if child == 15 { 1.0 } else { 2.0 }).unwrap();
            }
        }
        b.close_branch().unwrap();
        let tree = b.finish().unwrap();
        let bsdf = smooth(reflection(tree));
        let (wi, wo) = pair(DVec2::new(0.2, 0.3), DVec2::new(0.501, 0.3));
        bsdf.eval(wi, wo)
    };
    assert!((rise(2) - 2.0).abs() < 0.02, "{}", rise(2));
    assert!(rise(7) > 3.0, "{}", rise(7));
}

/// Light is moved within cells of incident directions, none is lost: totals have the same mean.
#[test]
fn totals_keep_their_mean_over_incidences() {
    let mean = |bsdf: &Bsdf| {
        // Two points a finest cell.
        let n = 64;
        let at = |i: u32| (f64::from(i / 2) + NODES[i as usize % 2]) / f64::from(n / 2);
        let points = (0..n * n).map(|i| DVec2::new(at(i % n), at(i / n)));
        let totals = points.map(|s| {
            let wi = square_to_hemisphere(s, Side::Front);
            bsdf.directional_hemispherical(wi, Components::ALL)
        });
        totals.sum::<f64>() / f64::from(n * n)
    };
    let stored = reflection(random_tree(Rank::Four, 5, 0.02, &mut Random(41)));
    let (before, after) = (mean(&stored), mean(&smooth(stored)));
    assert!((after / before - 1.0).abs() < 1e-6, "{before} {after}");
}

/// The constant part counts as Lambertian in both lookups; with it left in, draws follow f.
#[test]
fn constant_parts_are_the_same() {
    let stored = reflection(random_tree(Rank::Four, 3, 0.1, &mut Random(51)));
    let smooth = smooth(stored.clone());
    assert_eq!(stored.lambertian(), smooth.lambertian());
    let floor = smooth.components()[0].floor().y;
    assert!(floor > 0.0);
    let distribution = smooth.components()[0].distribution();
    let wi = square_to_hemisphere(DVec2::new(0.3, 0.4), Side::Front);
    let without = distribution.total(wi, Sense::Forward, floor);
    let with = distribution.total(wi, Sense::Forward, 0.0);
    assert!((with - without - PI * floor).abs() < 1e-9);
    // ∫ x f by quadrature and by draws.
    let (n, mut sum) = (256, 0.0);
    for i in 0..n * n {
        let s = DVec2::new(f64::from(i % n) + 0.5, f64::from(i / n) + 0.5) / f64::from(n);
        sum += s.x * distribution.value(wi, square_to_hemisphere(s, Side::Front));
    }
    let expected = sum * PI / f64::from(n * n) / with;
    let draws = 20_000;
    let drawn: f64 = (0..draws)
        .map(|i| {
            let u = (f64::from(i) + 0.5) / f64::from(draws);
            let disk = distribution.sample(wi, Sense::Forward, 0.0, u).unwrap();
            hemisphere_to_square(disk.extend(0.0)).x
        })
        .sum();
    let found = drawn / f64::from(draws);
    assert!((found - expected).abs() < 1e-3, "{found} drawn, {expected} expected");
}

#[test]
fn batches_are_single_queries() {
    let bsdf = smooth(of(vec![
        Component::new(
            Side::Front,
            Side::Front,
            TreeDistribution::new(random_tree(Rank::Four, 4, 0.02, &mut Random(61))),
        ),
        Component::new(
            Side::Back,
            Side::Front,
            TreeDistribution::new(random_tree(Rank::Three, 4, 0.0, &mut Random(62))),
        ),
    ]));
    let mut random = Random(63);
    let sides = [Side::Front, Side::Back];
    let mut directions = |flip: usize| -> Vec<DVec3> {
        let mut w: Vec<_> = (0..2000).map(|i| random.direction(sides[(i / flip) % 2])).collect();
        w[77] = DVec3::NAN;
        w
    };
    let (wi, wo) = (directions(1), directions(2));
    let u: Vec<f64> = (0..2000).map(|i| f64::from(i) / 2000.0).collect();
    let all = Components::ALL;
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let each = |f: &dyn Fn(usize) -> f64| bits(&(0..2000).map(f).collect::<Vec<_>>());
    let mut out = vec![0.0; 2000];
    bsdf.eval_many(&wi, &wo, &mut out).unwrap();
    assert_eq!(bits(&out), each(&|n| bsdf.eval(wi[n], wo[n])));
    bsdf.pdf_many(&wi, &wo, all, &mut out).unwrap();
    assert_eq!(bits(&out), each(&|n| bsdf.pdf(wi[n], wo[n], all)));
    bsdf.directional_hemispherical_many(&wi, all, &mut out).unwrap();
    assert_eq!(bits(&out), each(&|n| bsdf.directional_hemispherical(wi[n], all)));
    let mut samples = vec![None; 2000];
    bsdf.sample_many(&wi, &u, all, &mut samples).unwrap();
    for (n, sample) in samples.iter().enumerate() {
        assert_eq!(*sample, bsdf.sample(wi[n], u[n], all));
    }
}

#[test]
fn what_is_written_is_what_was_stored() {
    let stored = reflection(random_tree(Rank::Four, 3, 0.02, &mut Random(71)));
    let smooth = smooth(stored.clone());
    let written = |bsdf: &Bsdf| {
        let mut text = Vec::new();
        xml::write_to(bsdf, &mut text, &xml::WriteOptions::default()).unwrap();
        text
    };
    assert!(written(&stored) == written(&smooth));
    let back = smooth.clone().with_lookup(Lookup::Stored).unwrap();
    let mut random = Random(72);
    let mut differ = 0;
    for _ in 0..1000 {
        let (wi, wo) = (random.direction(Side::Front), random.direction(Side::Front));
        assert_eq!(back.eval(wi, wo).to_bits(), stored.eval(wi, wo).to_bits());
        differ += u32::from(smooth.eval(wi, wo) != stored.eval(wi, wo));
    }
    assert!(differ > 300, "{differ}");
}

#[test]
fn matrices_are_as_they_were() {
    let basis = KlemsBasis::quarter();
    let n = basis.directions();
    let values = (0..n * n).map(|i| (i % 17) as f32).collect();
    let matrix = KlemsMatrix::new(basis.clone(), basis, values).unwrap();
    let stored = of(vec![Component::new(Side::Front, Side::Back, matrix)]);
    let smooth = smooth(stored.clone());
    let mut random = Random(81);
    for _ in 0..1000 {
        let (wi, wo) = (random.direction(Side::Front), random.direction(Side::Back));
        assert_eq!(smooth.eval(wi, wo), stored.eval(wi, wo));
        let u = random.unit();
        let all = Components::ALL;
        assert_eq!(smooth.sample(wi, u, all), stored.sample(wi, u, all));
    }
}

/// A compiled file opened in place is not looked through; smooth lookup is made from all of it.
#[test]
fn damage_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.safetensors");
    let marked = grid(2, |p, q| if p + q == DVec2::splat(0.25) { 3.25 } else { 1.0 });
    container::save(&reflection(marked), &path).unwrap();
    let sound = container::open(&path).unwrap().with_lookup(Lookup::Smooth).unwrap();
    assert!(sound.eval(DVec3::Z, DVec3::Z) >= 0.0);
    let mut bytes = std::fs::read(&path).unwrap();
    // A leaf becomes a branch that does not exist.
    for word in bytes.chunks_exact_mut(4).filter(|word| **word == 3.25_f32.to_le_bytes()) {
        word.fill(0xff);
    }
    let damaged = folder.path().join("damaged.safetensors");
    std::fs::write(&damaged, bytes).unwrap();
    let opened = container::open(&damaged).unwrap();
    let error = opened.with_lookup(Lookup::Smooth).unwrap_err();
    assert_eq!(error.class(), bsdfkit::ErrorClass::Format);
}

#[test]
fn colour_is_as_stored() {
    let file =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/xml/color_tree_0.6_0.3.xml");
    let stored = Bsdf::open(file).unwrap();
    let smooth = smooth(Bsdf::open(file).unwrap());
    let mut random = Random(5);
    let mut coloured = 0;
    for _ in 0..2000 {
        let (wi, wo) = (random.direction(Side::Front), random.direction(Side::Front));
        let (a, b) = (stored.eval_xyz(wi, wo), smooth.eval_xyz(wi, wo));
        assert!((b.y - smooth.eval(wi, wo)).abs() < 1e-6 * b.y.max(1.0));
        if a.y > 1e-6 && b.y > 1e-6 {
            assert!((a.x / a.y - b.x / b.y).abs() < 1e-5, "{a:?} {b:?}");
            assert!((a.z / a.y - b.z / b.y).abs() < 1e-5, "{a:?} {b:?}");
            coloured += usize::from((a.x / a.y - 1.0).abs() > 0.1);
        }
    }
    assert!(coloured > 500, "{coloured}");
}
