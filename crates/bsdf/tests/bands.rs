//! Spectra of stored BSDFs: values and totals of bands, the golden container, what is refused.

use std::f64::consts::PI;
use std::path::Path;

use bsdfkit::spectrum::{Bands, Basis, Hue};
use bsdfkit::tree::{Rank, TensorTree, TreeBuilder, TreeDistribution, TreeHues};
use bsdfkit::{Bsdf, Component, Components, DVec3, Lambertian, Metadata, Side, container};
use bsdfkit_sphere::direction::from_degrees;

/// Bands of a hue that is told by one number; the luminance weighs the middle band most.
fn hue() -> Hue {
    let bands = Bands::new(vec![450.0, 550.0, 650.0]).unwrap();
    let root = 1.5_f64.sqrt();
    let basis = Basis::new(bands, vec![0.0; 3], vec![vec![root, 0.0, -root]], 0.0).unwrap();
    Hue::new(basis, vec![0.25, 0.5, 0.25], 1e-9).unwrap()
}

/// Rank 3, children of values 0.05 and 0.1: the darker ones where light scatters back.
fn tree() -> TensorTree {
    let mut b = TreeBuilder::new(Rank::Three);
    b.open_branch().unwrap();
    (0..8).for_each(|child| b.leaf(if child / 2 % 2 == 0 { 0.05 } else { 0.1 }).unwrap());
    b.close_branch().unwrap();
    b.finish().unwrap()
}

/// Blue behind, red ahead.
fn bsdf() -> Bsdf {
    let tree = tree();
    let mut coefficients = vec![0.0; tree.hue_rows()];
    for leaf in tree.leaf_cells() {
        coefficients[leaf.row as usize] = if leaf.scattered % 2 == 0 { 0.5 } else { -0.5 };
    }
    let hues = TreeHues::new(hue(), &coefficients).unwrap();
    let tree = TreeDistribution::new(tree).with_hues(hues).unwrap();
    let component = Component::new(Side::Front, Side::Front, tree);
    Bsdf::new(Metadata::default(), vec![component], Lambertian::default())
}

/// e^(±a √1.5) and 1 over their mean by the weights of the luminance.
fn expected(a: f64) -> [f64; 3] {
    let [blue, red] = [1.0, -1.0].map(|sign: f64| (sign * a * 1.5_f64.sqrt()).exp());
    let mean = 0.25 * blue + 0.5 + 0.25 * red;
    [blue / mean, 1.0 / mean, red / mean]
}

#[test]
fn bands_of_leaves_are_their_luminance_in_their_hue() {
    let bsdf = bsdf();
    assert_eq!(bsdf.wavelengths().unwrap().nanometres(), [450.0, 550.0, 650.0]);
    let wi = from_degrees(40.0, 70.0);
    // The travel direction is ahead.
    for (wo, a) in [(from_degrees(50.0, 255.0), -0.5), (from_degrees(50.0, 75.0), 0.5)] {
        let mut bands = [0.0; 3];
        bsdf.eval_bands(wi, wo, &mut bands).unwrap();
        let y = bsdf.eval(wi, wo);
        assert!(y > 0.04);
        for (band, part) in bands.iter().zip(expected(a)) {
            assert!((band / (y * part) - 1.0).abs() < 3e-3, "{bands:?} {y} {:?}", expected(a));
        }
    }
}

#[test]
fn totals_add_up_to_the_light() {
    let bsdf = bsdf();
    let wi = from_degrees(40.0, 70.0);
    let mut bands = [0.0; 3];
    bsdf.directional_hemispherical_bands(wi, Components::ALL, &mut bands).unwrap();
    let light = bsdf.directional_hemispherical(wi, Components::ALL);
    assert!((0.25 * bands[0] + 0.5 * bands[1] + 0.25 * bands[2] - light).abs() < 1e-6 * light);
    // Half of the hemisphere behind, 0.05; half ahead, 0.1.
    let of = |band: usize| PI * 0.5 * (0.05 * expected(0.5)[band] + 0.1 * expected(-0.5)[band]);
    for (band, found) in bands.iter().enumerate() {
        assert!((found / of(band) - 1.0).abs() < 4e-3, "{band}: {found} {}", of(band));
    }
    bsdf.directional_hemispherical_bands(wi, Components::TRANSMISSION, &mut bands).unwrap();
    assert_eq!(bands, [0.0; 3]);
    bsdf.directional_hemispherical_bands(DVec3::NAN, Components::ALL, &mut bands).unwrap();
    assert!(bands.iter().all(|v| v.is_nan()));
}

#[test]
fn the_golden_file_holds_these_bands() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/compiled");
    let path = folder.join("spectral_tree.safetensors");
    if std::env::var_os("BSDFKIT_REMAKE_GOLDEN").is_some() {
        container::save(&bsdf(), &path).unwrap();
    }
    let wi = from_degrees(40.0, 70.0);
    for kept in [container::load(&path).unwrap(), container::open(&path).unwrap()] {
        for k in 0..200 {
            let wo = from_degrees(f64::from(k) * 0.45, f64::from(k) * 137.5);
            let [mut a, mut b] = [[0.0; 3]; 2];
            kept.eval_bands(wi, wo, &mut a).unwrap();
            bsdf().eval_bands(wi, wo, &mut b).unwrap();
            let near = a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1e-12 * b);
            assert!(near, "{a:?} {b:?}: see CONTRIBUTING.md");
        }
    }
}

#[test]
fn what_has_no_bands_or_not_the_same_says_so() {
    let plain = || {
        let tree = TreeDistribution::new(tree());
        Component::new(Side::Back, Side::Back, tree)
    };
    let both = Bsdf::new(
        Metadata::default(),
        vec![bsdf().components()[0].clone(), plain()],
        Lambertian::default(),
    );
    assert!(both.wavelengths().is_none());
    let message = both.eval_bands(DVec3::Z, DVec3::Z, &mut [0.0; 3]).expect_err("refused");
    assert!(message.to_string().contains("found 3 bands, 450 to 650 nm; none"), "{message}");
    let message = bsdf().eval_bands_many(&[DVec3::Z], &[DVec3::Z; 4], &mut [0.0; 9]);
    assert!(message.expect_err("3 results").to_string().contains("wo: expected 3 elements"));
    let hues = TreeHues::new(hue(), &[0.0; 3]).unwrap();
    let message = TreeDistribution::new(tree()).with_hues(hues).expect_err("three rows");
    assert!(message.to_string().contains("expected 8 coefficients"), "{message}");
}
