//! Peaks of no width beside trees, matrices and Lambertian parts: the verbs, samples, files.
//!
//! Seeds are fixed.

mod chi_squared;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use std::f64::consts::PI;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::specular::{Curve, Law};
use bsdfkit::tree::{Rank, TensorTree, TreeDistribution};
use bsdfkit::xml::{Limits, WriteOptions};
use bsdfkit::{
    Bsdf, Component, Components, DVec2, DVec3, Lambertian, Metadata, Part, Scatter, Side, Specular,
    Xyz, container, xml,
};
use bsdfkit_sphere::concentric::{hemisphere_to_square, square_to_hemisphere};
use bsdfkit_sphere::direction::from_degrees;
use support::{Random, random_tree};

use Side::{Back, Front};

/// Coloured, and different in every direction.
fn curve() -> Curve {
    Curve::tabulated(19, 12, |w| {
        let y = 0.3 + 0.1 * w.z + 0.1 * w.x;
        Xyz::new(0.9 * y, y, 1.2 * y)
    })
    .unwrap()
}

fn isotropic() -> Curve {
    Curve::tabulated(31, 1, |w| Xyz::grey(0.2 + 0.5 * w.z)).unwrap()
}

fn mirror() -> Specular {
    Specular::new((Front, Front), Law::OPPOSITE, isotropic())
}

fn straight() -> Specular {
    Specular::new((Front, Back), Law::OPPOSITE, isotropic())
}

fn order() -> Specular {
    let law = Law::OPPOSITE.shifted(DVec2::new(0.3, 0.1)).unwrap();
    let residual = Some(0.0123);
    Specular { width_degrees: 0.5, residual, ..Specular::new((Front, Back), law, curve()) }
}

fn tree(rank: Rank, floor: f32, seed: u64) -> TreeDistribution {
    TreeDistribution::new(random_tree(rank, 3, floor, &mut Random(seed)))
}

fn coloured_tree() -> TreeDistribution {
    let [y, u, v] = [1, 2, 3].map(|seed| random_tree(Rank::Four, 2, 0.1, &mut Random(seed)));
    TreeDistribution::with_chromaticity(y, u, v).unwrap()
}

fn matrix(coloured: bool, seed: u64) -> KlemsMatrix {
    let (basis, random) = (KlemsBasis::quarter(), &mut Random(seed));
    let mut values = || (0..41 * 41).map(|_| 0.02 + random.unit().powi(6) as f32).collect();
    let grey = KlemsMatrix::new(basis.clone(), basis, values()).unwrap();
    if coloured { grey.with_colour(values(), values()).unwrap() } else { grey }
}

fn of(components: Vec<Component>, specular: Vec<Specular>) -> Bsdf {
    let none = Lambertian::default();
    Bsdf::new(Metadata::default(), components, none).with_specular(specular)
}

fn cases() -> Vec<(&'static str, Bsdf)> {
    let lambertian = Lambertian { reflection_front: Xyz::grey(0.2), ..Lambertian::default() };
    vec![
        ("rank 4 and an order", {
            of(
                vec![Component::new(Front, Back, tree(Rank::Four, 0.02, 1))],
                vec![straight(), order()],
            )
        }),
        ("rank 3 and a mirror", {
            of(vec![Component::new(Front, Front, tree(Rank::Three, 0.0, 2))], vec![mirror()])
        }),
        ("matrix, both ways", {
            let c = vec![
                Component::new(Front, Front, matrix(false, 3)),
                Component::new(Front, Back, matrix(false, 4)),
            ];
            of(c, vec![mirror(), straight()])
        }),
        ("Lambertian", {
            Bsdf::new(Metadata::default(), Vec::new(), lambertian)
                .with_specular(vec![mirror(), straight()])
        }),
    ]
}

const INCIDENCES: [(f64, f64); 4] = [(0.0, 0.0), (33.0, 70.0), (76.0, 201.0), (140.0, 20.0)];

#[test]
fn laws_say_where_light_goes_and_curves_how_much() {
    let bsdf = of(Vec::new(), vec![mirror(), order()]);
    let wi = from_degrees(40.0, 200.0);
    let peaks: Vec<_> = bsdf.specular_peaks(wi, Components::ALL).collect();
    assert_eq!(peaks.len(), 2);
    assert!(peaks[0].wo.distance(from_degrees(40.0, 20.0)) < 1e-12);
    assert!((peaks[0].coefficient.y - (0.2 + 0.5 * wi.z)).abs() < 1e-3);
    let u = wi.truncate();
    assert!((peaks[1].wo.truncate() - (DVec2::new(0.3, 0.1) - u)).length() < 1e-12);
    assert!(peaks[1].wo.z < 0.0);
    // f has none of it.
    assert_eq!(bsdf.eval(wi, peaks[0].wo), 0.0);
    assert_eq!(bsdf.eval_components(wi, peaks[0].wo, Components::ALL), 0.0);
    // From behind an order goes back the way it would have come.
    let back: Vec<_> = bsdf.specular_peaks(peaks[1].wo, Components::ALL).collect();
    assert_eq!(back.len(), 1);
    assert!(back[0].wo.distance(wi) < 1e-12);
    assert!((back[0].coefficient.y - peaks[1].coefficient.y).abs() < 1e-12);
    // Beyond the horizon, and no direction at all.
    assert_eq!(bsdf.specular_peaks(from_degrees(80.0, 180.0), Components::ALL).count(), 1);
    assert_eq!(bsdf.specular_peaks(DVec3::NAN, Components::ALL).count(), 0);
}

#[test]
fn a_stored_way_back_is_asked_before_a_reversed_one() {
    let weak = Specular { incident: Back, scattered: Front, ..straight() };
    let weak = Specular { coefficient: Curve::constant(Xyz::grey(0.1)).unwrap(), ..weak };
    let bsdf = of(Vec::new(), vec![straight(), weak]);
    let wi = from_degrees(150.0, 0.0);
    let peaks: Vec<_> = bsdf.specular_peaks(wi, Components::ALL).collect();
    assert_eq!(peaks.len(), 1);
    assert!((peaks[0].coefficient.y - 0.1).abs() < 1e-12);
    // Where a component answers from behind, and no peak is stored, there is none.
    let component = Component::new(Back, Front, tree(Rank::Three, 0.0, 2));
    let bsdf = of(vec![component], vec![straight()]);
    assert_eq!(bsdf.specular_peaks(wi, Components::ALL).count(), 0);
    // As a peak of its own it is the same as in reverse.
    let lone = of(Vec::new(), vec![order()]);
    let own = of(Vec::new(), vec![order().reversed()]);
    for (theta, phi) in [(170.0, 20.0), (155.0, 80.0), (150.0, 200.0)] {
        let wi = from_degrees(theta, phi);
        let [a, b] = [&lone, &own].map(|b| b.specular_peaks(wi, Components::ALL).next().unwrap());
        assert!(a.wo.distance(b.wo) < 1e-12);
        assert!((a.coefficient.y - b.coefficient.y).abs() < 3e-3, "{theta}");
    }
}

#[test]
fn flags_tell_kinds_apart() {
    let component = Component::new(Front, Back, tree(Rank::Four, 0.05, 5));
    let bsdf = of(vec![component], vec![straight(), mirror()]);
    let wi = from_degrees(25.0, 40.0);
    let total = |c| bsdf.directional_hemispherical(wi, c);
    let peak = 0.2 + 0.5 * wi.z;
    assert!((total(Components::SPECULAR) - 2.0 * peak).abs() < 2e-3);
    assert!((total(Components::SPECULAR & Components::REFLECTION) - peak).abs() < 1e-3);
    let kinds = [Components::LAMBERTIAN, Components::DIRECTIONAL_DIFFUSE, Components::SPECULAR];
    let sum: f64 = kinds.map(total).iter().sum();
    assert!((sum - total(Components::ALL)).abs() < 1e-12);
    let both = total(Components::DIRECTIONAL_DIFFUSE) + total(Components::SPECULAR);
    assert!((both - total(Components::NON_LAMBERTIAN)).abs() < 1e-12);
    // The reference library's flags know no third kind: what is not Lambertian is all of it.
    assert_eq!(Components::from_bits(4 | 1 | 2), Components::NON_LAMBERTIAN);
    assert_eq!(Components::from_bits(63), Components::ALL);
    assert_eq!(Components::from_bits(64 | 3), Components::SPECULAR);
    assert_eq!(Components::from_bits(4 | 128 | 3), Components::DIRECTIONAL_DIFFUSE);
    for c in [Components::ALL, Components::SPECULAR, Components::NON_LAMBERTIAN, Components::NONE] {
        assert_eq!(Components::from_bits(c.bits() | 48).bits() & 207, c.bits() & 207);
    }
    assert!(!Components::LAMBERTIAN.selects(Front, true, Scatter::Specular));
    assert_eq!(Components::SPECULAR & Components::LAMBERTIAN, Components::from_bits(3 | 48));
}

/// Cells of the square per side and hemisphere.
const GRID: usize = 12;

fn bin(w: DVec3) -> usize {
    let s = hemisphere_to_square(w) * GRID as f64;
    let cell = |c: f64| (c as usize).min(GRID - 1);
    let side = usize::from(Side::of(w) == Back) * GRID * GRID;
    side + cell(s.y) * GRID + cell(s.x)
}

/// ∫ pdf over each bin, then a bin for each peak.
fn expected(bsdf: &Bsdf, wi: DVec3) -> Vec<f64> {
    let steps = GRID * 20;
    let point = |n: usize| (n as f64 + 0.5) / steps as f64;
    let mut bins = vec![0.0; 2 * GRID * GRID + bsdf.specular().len()];
    for side in [Front, Back] {
        for n in 0..steps * steps {
            let square = DVec2::new(point(n / steps), point(n % steps));
            let wo = square_to_hemisphere(square, side);
            let density = bsdf.pdf(wi, wo, Components::ALL);
            bins[bin(wo)] += density / wo.z.abs() * PI / (steps * steps) as f64;
        }
    }
    let total = bsdf.directional_hemispherical(wi, Components::ALL);
    for peak in bsdf.specular_peaks(wi, Components::ALL) {
        bins[2 * GRID * GRID + peak.index] += peak.coefficient.y / total;
    }
    bins
}

#[test]
fn samples_follow_the_density_and_the_peaks() {
    let draws = 20_000;
    let cases = cases();
    let level = chi_squared::level(2 * cases.len() * INCIDENCES.len());
    for (seed, (name, bsdf)) in cases.iter().enumerate() {
        let random = &mut Random(300 + seed as u64);
        for (theta, phi) in INCIDENCES {
            let wi = from_degrees(theta, phi);
            let total = bsdf.directional_hemispherical(wi, Components::ALL);
            if total == 0.0 {
                assert!(bsdf.sample(wi, 0.5, Components::ALL).is_none());
                continue;
            }
            if bsdf.specular_peaks(wi, Components::ALL).any(|p| p.coefficient.y >= total) {
                continue; // nothing to choose from
            }
            let expected = expected(bsdf, wi);
            let sum: f64 = expected.iter().sum();
            assert!((sum - 1.0).abs() < 1e-2, "{name} at {theta}°: {sum}");
            let expected: Vec<f64> = expected.iter().map(|e| e * f64::from(draws)).collect();
            let mut observed = [vec![0.0; expected.len()], vec![0.0; expected.len()]];
            for _ in 0..draws {
                let u = DVec2::new(random.unit(), random.unit());
                let drawn =
                    [bsdf.sample(wi, u.x, Components::ALL), bsdf.sample2(wi, u, Components::ALL)];
                for (observed, sample) in observed.iter_mut().zip(drawn) {
                    let sample = sample.expect(name);
                    assert!((sample.weight / total - 1.0).abs() < 1e-9, "{name}");
                    let at = match sample.part {
                        Part::Specular(index) => {
                            let mut peaks = bsdf.specular_peaks(wi, Components::ALL);
                            let peak = peaks.find(|p| p.index == index).unwrap();
                            assert_eq!(sample.wo, peak.wo);
                            assert!((sample.pdf - peak.coefficient.y / total).abs() < 1e-12);
                            2 * GRID * GRID + index
                        }
                        _ => {
                            let pdf = bsdf.pdf(wi, sample.wo, Components::ALL);
                            assert!((sample.pdf / pdf - 1.0).abs() < 1e-6, "{name}");
                            bin(sample.wo)
                        }
                    };
                    observed[at] += 1.0;
                }
            }
            for (numbers, observed) in observed.iter().enumerate() {
                let name = format!("{name} at {theta}°, sample{}", numbers + 1);
                chi_squared::expect(&name, observed, &expected, level);
            }
        }
    }
}

#[test]
fn many_are_as_one() {
    let random = &mut Random(9);
    for (name, bsdf) in cases() {
        let side = |n: usize| if n.is_multiple_of(3) { Back } else { Front };
        let wi: Vec<DVec3> = (0..600).map(|n| random.direction(side(n))).collect();
        let wo: Vec<DVec3> = (0..600).map(|n| random.direction(side(n / 2))).collect();
        let u: Vec<f64> = (0..600).map(|_| random.unit()).collect();
        for components in [Components::ALL, Components::SPECULAR, Components::TRANSMISSION] {
            let mut totals = vec![0.0; 600];
            bsdf.directional_hemispherical_many(&wi, components, &mut totals).unwrap();
            let mut densities = vec![0.0; 600];
            bsdf.pdf_many(&wi, &wo, components, &mut densities).unwrap();
            let mut samples = vec![None; 600];
            bsdf.sample_many(&wi, &u, components, &mut samples).unwrap();
            for n in 0..600 {
                assert_eq!(totals[n], bsdf.directional_hemispherical(wi[n], components), "{name}");
                assert_eq!(densities[n], bsdf.pdf(wi[n], wo[n], components), "{name}");
                assert_eq!(samples[n], bsdf.sample(wi[n], u[n], components), "{name}");
            }
        }
    }
}

#[test]
fn the_container_holds_them_exactly() {
    for (name, bsdf) in cases() {
        let bytes = container::to_bytes(&bsdf).unwrap();
        let back = container::from_bytes(&bytes).unwrap();
        assert_eq!(back.specular(), bsdf.specular(), "{name}");
        assert_eq!(container::to_bytes(&back).unwrap(), bytes, "{name}");
    }
    // Without peaks the file is as it always was.
    let plain = of(vec![Component::new(Front, Front, matrix(false, 3))], Vec::new());
    let text = String::from_utf8_lossy(&container::to_bytes(&plain).unwrap()).into_owned();
    assert!(!text.contains("specular") && text.contains("\\\"version\\\":1"));
}

#[test]
fn a_damaged_container_is_refused() {
    let bytes = container::to_bytes(&of(Vec::new(), vec![order()])).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let at = text.find("\\\"width_degrees\\\":0.5").unwrap();
    let mut damaged = bytes.clone();
    damaged[at + 18..at + 21].copy_from_slice(b"9e9");
    let error = container::from_bytes(&damaged).unwrap_err().to_string();
    assert!(error.contains("specular.0.coefficient: width"), "{error}");
}

fn written(bsdf: &Bsdf) -> String {
    let mut out = Vec::new();
    let options = WriteOptions { digits: 9, ..WriteOptions::default() };
    xml::write_to(bsdf, &mut out, &options).unwrap();
    String::from_utf8(out).unwrap()
}

fn xml_cases() -> Vec<(&'static str, Bsdf)> {
    let of_tree = |c, s| of(vec![Component::new(Front, Back, c)], s);
    vec![
        ("rank 4", of_tree(tree(Rank::Four, 0.02, 1), vec![straight(), order()])),
        ("rank 3", of_tree(tree(Rank::Three, 0.02, 2), vec![straight()])),
        ("a mirror beside", of_tree(tree(Rank::Three, 0.02, 2), vec![straight(), mirror()])),
        ("coloured trees", of_tree(coloured_tree(), vec![order()])),
        ("nothing else", of(Vec::new(), vec![mirror(), straight()])),
        ("matrix", of(vec![Component::new(Front, Back, matrix(false, 3))], vec![straight()])),
        ("coloured matrix", of(vec![Component::new(Front, Back, matrix(true, 4))], vec![order()])),
    ]
}

/// Nothing is lost; and what programs read that know no peaks has all the light.
#[test]
fn xml_comes_back_and_has_all_the_light_in_cells() {
    let random = &mut Random(12);
    for (name, bsdf) in xml_cases() {
        let text = written(&bsdf);
        let (back, warnings) = xml::from_bytes(text.as_bytes(), &Limits::default()).unwrap();
        // Trees at random have more light than came.
        let other = warnings.iter().find(|w| !w.text.contains("of the light is scattered"));
        assert!(other.is_none(), "{name}: {other:?}");
        assert_eq!(back.specular(), bsdf.specular(), "{name}");
        assert_eq!(back.components().len(), bsdf.components().len(), "{name}");
        assert!(back.metadata().unread.is_empty(), "{name}");
        for n in 0..500 {
            let wi = random.direction(if n % 4 == 0 { Back } else { Front });
            let wo = random.direction(if n % 3 == 0 { Front } else { Back });
            for wo in [wo, -wi] {
                let [a, b] = [&bsdf, &back].map(|b| b.eval_xyz(wi, wo));
                assert_eq!(a, b, "{name} {wi} {wo}");
            }
        }
        assert_eq!(written(&back), text, "{name}");

        // Without the block.
        let from = text.find("<SpecularComponents>").unwrap();
        let to = text.find("</SpecularComponents>").unwrap() + "</SpecularComponents>".len();
        let bare = format!("{}{}", &text[..from], &text[to..]);
        let (bare, _) = xml::from_bytes(bare.as_bytes(), &Limits::default()).unwrap();
        assert!(bare.specular().is_empty());
        // A cell has the mean of what its incident directions have, where an order passes the horizon, too: the mean over
        // many directions tells.
        let (mut all, mut off) = (0.0, 0.0);
        for n in 0..400 {
            let wi = from_degrees(f64::from(n) * 0.19, f64::from(n) * 77.0);
            let [a, b] = [&bsdf, &bare].map(|b| b.directional_hemispherical(wi, Components::ALL));
            all += a;
            off += b - a;
        }
        assert!(off.abs() < 0.02 * all, "{name}: {all}, off by {off}");
        let cells = bsdf.with_peaks_in_cells().unwrap();
        // Not on the border of a cell, as 30 degrees would be.
        let wi = from_degrees(31.0, 15.0);
        let [a, b] = [&cells, &bare].map(|b| b.eval(wi, -wi));
        assert!((a - b).abs() < 1e-6 * a, "{name}: {a} {b}");
    }
}

#[test]
fn faults_in_the_block_are_named() {
    let text = written(&of(vec![Component::new(Front, Back, matrix(false, 3))], vec![straight()]));
    let refused = |from: &str, to: &str, words: &str| {
        assert!(text.contains(from), "{from}");
        let text = text.replacen(from, to, 1);
        let error = xml::from_bytes(text.as_bytes(), &Limits::default()).unwrap_err().to_string();
        assert!(error.contains(words), "{to}: {error}");
        assert!(error.contains("SpecularComponents"), "{to}: {error}");
    };
    refused("<Law>-1 0 0 -1 0 0</Law>", "<Law>-1 0 0</Law>", "expected 6 numbers, found 3");
    refused("<Law>-1 0 0 -1 0 0</Law>", "<Law>0 0 0 0 0 0</Law>", "inverse");
    refused("<Rings>31</Rings>", "<Rings>30</Rings>", "expected 30 × 1 numbers");
    refused("<Rings>31</Rings>", "<Rings>99999999999999999999</Rings>", "expected a count");
    refused("<WidthDegrees>0</WidthDegrees>", "<WidthDegrees>90</WidthDegrees>", "0 to 20 degrees");
    refused("<Channel>Y</Channel>", "<Channel>u</Channel>", "does not have");
    refused("<Coefficients>\n0.7", "<Coefficients>\nx", "expected numbers, found \"x\"");
    refused("<Coefficients>\n0.7", "<Coefficients>\n-1", "values of 0 to 10");
    refused("<Values>\n0\n", "<Values>\n99999\n", "expected entries below");
    refused("<Values>\n0\n", "<Values>\n0 0\n", "expected pairs");
}

/// A mirror in rank 4 cells stands where Radiance looks for it, at the diagonal.
#[test]
fn one_value_of_a_peak_in_cells_is_coefficient_over_cell() {
    let black = TreeDistribution::new(TensorTree::constant(Rank::Four, 0.0).unwrap());
    let constant = Curve::constant(Xyz::grey(0.8)).unwrap();
    let mirror = Specular::new((Front, Front), Law::OPPOSITE, constant);
    let bsdf = of(vec![Component::new(Front, Front, black)], vec![mirror]);
    let cells = bsdf.with_peaks_in_cells().unwrap();
    let wi = from_degrees(37.0, 61.0);
    let mirrored = DVec3::new(-wi.x, -wi.y, wi.z);
    let size = PI / 64.0 / 64.0;
    assert!((cells.eval(wi, mirrored) * size / 0.8 - 1.0).abs() < 1e-6);
    assert!((cells.directional_hemispherical(wi, Components::ALL) - 0.8).abs() < 1e-6);
}

/// Beside grey scatter of the other side, too: where nothing else was, the peak's colour is all that there is.
#[test]
fn a_coloured_peak_alone_keeps_its_colour_in_cells() {
    let colour = Xyz::new(0.3, 0.5, 0.8);
    let peak = Specular::new((Front, Back), Law::OPPOSITE, Curve::constant(colour).unwrap());
    let reflecting = |matrix| match matrix {
        true => Component::new(Front, Front, self::matrix(false, 3)),
        false => Component::new(Front, Front, tree(Rank::Three, 0.02, 1)),
    };
    for (name, components) in [
        ("nothing else", vec![]),
        ("a grey tree", vec![reflecting(false)]),
        ("a grey matrix", vec![reflecting(true)]),
    ] {
        let cells = of(components, vec![peak.clone()]).with_peaks_in_cells().unwrap();
        let wi = from_degrees(31.0, 15.0);
        let found = cells.eval_xyz(wi, -wi);
        for (found, expected) in [(found.x, colour.x), (found.z, colour.z)] {
            let [found, expected] = [found / cells.eval(wi, -wi), expected / colour.y];
            assert!((found / expected - 1.0).abs() < 1e-3, "{name}: {found} {expected}");
        }
    }
}

/// Trees and matrices that hold peaks in their cells, as other programs write them.
#[test]
fn peaks_are_found_in_cells_once_and_again() {
    let flat = |rank| TreeDistribution::new(TensorTree::constant(rank, 0.05).unwrap());
    let basis = KlemsBasis::full();
    let matrix = KlemsMatrix::new(basis.clone(), basis, vec![0.05; 145 * 145]).unwrap();
    let component = |scattered| match scattered {
        Back => Component::new(Front, Back, flat(Rank::Four)),
        Front => Component::new(Front, Front, flat(Rank::Three)),
    };
    let retro = Specular { law: Law::RETRO, ..mirror() };
    for (name, component, peak) in [
        ("straight through, rank 4", component(Back), straight()),
        ("mirror, rank 3", component(Front), mirror()),
        ("retro, rank 3", component(Front), retro),
        ("straight through, matrix", Component::new(Front, Back, matrix), straight()),
    ] {
        let law = peak.law;
        let before = of(vec![component], vec![peak]);
        let cells = before.with_peaks_in_cells().unwrap();
        let found = cells.with_peaks_extracted().unwrap();
        assert_eq!(found.specular().len(), 1, "{name}");
        assert_eq!(found.specular()[0].law, law, "{name}");
        for theta in [3.0, 20.0, 41.0, 62.0, 75.0] {
            let wi = from_degrees(theta, 33.0);
            let [a, b] = [&before, &found].map(|b| b.specular()[0].coefficient.at(wi).y);
            let [e, f] =
                [&before, &found].map(|b| b.directional_hemispherical(wi, Components::ALL));
            // Cells are wide in polar angle at grazing, patches of a matrix everywhere: they have means.
            let wide = name.ends_with("matrix") || theta > 70.0;
            let mean = if wide { 0.05 } else { 0.0 };
            assert!((a / b - 1.0).abs() < 0.01 + mean, "{name} at {theta}: {a} {b}");
            assert!((e / f - 1.0).abs() < 0.01 + mean, "{name} at {theta}: {e} {f}");
            let wo = law.scattered(wi, found.specular()[0].scattered).unwrap();
            assert!(
                (found.eval(wi, wo) / 0.05 - 1.0).abs() < 1e-3,
                "{name}: {}",
                found.eval(wi, wo)
            );
        }
        let again = found.with_peaks_extracted().unwrap();
        assert_eq!(written(&again), written(&found), "{name}");
        assert_eq!(written(&cells.with_peaks_extracted().unwrap()), written(&found), "{name}");
    }
}

#[test]
fn no_peak_is_found_where_there_is_none() {
    for seed in 0..6 {
        let trees = [Rank::Three, Rank::Four].map(|rank| {
            Component::new(
                Front,
                Front,
                TreeDistribution::new(random_tree(rank, 5, 0.0, &mut Random(seed))),
            )
        });
        for c in trees {
            assert!(of(vec![c], Vec::new()).with_peaks_extracted().unwrap().specular().is_empty());
        }
        let c = Component::new(Front, Back, matrix(false, seed));
        assert!(of(vec![c], Vec::new()).with_peaks_extracted().unwrap().specular().is_empty());
    }
}
