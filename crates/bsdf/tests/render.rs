//! The render form: do samples follow their density, do files keep it, does nothing break it?
//!
//! Tables here hold any numbers; what they are made of is another matter. Seeds are fixed.

mod chi_squared;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use std::f64::consts::PI;
use std::path::Path;

use bsdfkit::render::{Chart, Content, Fold, Frame, FrameKind, Layer, Pose, RenderTable, Shape};
use bsdfkit::{
    Bsdf, Component, Components, DVec2, DVec3, Lambertian, Metadata, Side, Xyz, container,
};
use bsdfkit_sphere::concentric::{hemisphere_to_square, square_to_hemisphere};
use bsdfkit_sphere::direction::from_degrees;
use support::Random;

fn shape(kind: FrameKind, colour: bool) -> Shape {
    Shape {
        frame: Frame { kind, factor: -0.85 },
        angles: 7,
        radii: 6,
        core: 0.1,
        far: 6.0,
        colour_angles: if colour { 3 } else { 0 },
        colour_radii: if colour { 4 } else { 0 },
        drawn_angles: 6,
        drawn_radii: 8,
        value_unit: 1.0,
        drawn_unit: 1.0,
    }
}

/// A table of two layers, each in a plane of its own, of peaks that wander.
fn table(fold: Fold, colour: bool, random: &mut Random) -> RenderTable {
    let chart = Chart::new(fold, 3, 1.0).unwrap();
    let fine = chart.refined(2);
    let across = if fold == Fold::IsotropicMirrored { 0.0 } else { 1.0 };
    let kinds = [FrameKind::Slopes, FrameKind::Cosines];
    let poses: Vec<Vec<Pose>> = kinds
        .iter()
        .map(|_| {
            let pose = |_| {
                let mut near = |c: f64| c as f32 + 0.1 * (random.unit() as f32 - 0.5);
                let aside = near(0.0) * across as f32;
                let stretch = [near(1.3), near(0.2) * across as f32, near(0.8)];
                Pose { centre: [near(0.0), aside], stretch }
            };
            (0..fine.nodes()).map(pose).collect()
        })
        .collect();
    let layers = kinds.map(|kind| {
        let shape = shape(kind, colour);
        let nodes = chart.nodes();
        let mut some = |count: usize, least: f64| -> Vec<f64> {
            (0..count).map(|_| least + random.unit()).collect()
        };
        // As in tables that are made: none in the peak's middle nor at the horizon, where area and cosine vanish.
        let mut density = some(nodes * 7 * 9, 0.05);
        for (n, density) in density.iter_mut().enumerate() {
            *density *= f64::from(u8::from(!matches!(n % 9, 0 | 8)));
        }
        let content = Content {
            values: some(nodes * 8 * 7, 0.0),
            colour: if colour { some(nodes * 4 * 5 * 2, 0.5) } else { Vec::new() },
            density,
            hue: Vec::new(),
        };
        Layer::new(&chart, shape, &content).unwrap()
    });
    let mut some = |count: usize, least: f32| -> Vec<f32> {
        (0..count).map(|_| least + random.unit() as f32).collect()
    };
    let (totals, factors) = (some(fine.nodes(), 0.3), some(2 * fine.nodes(), 0.5));
    let table = RenderTable::new(chart, layers.into(), &poses).unwrap();
    table.with_energy(&totals, &factors).unwrap()
}

fn of(components: Vec<Component>) -> Bsdf {
    Bsdf::new(Metadata::default(), components, Lambertian::default())
}

fn cases() -> Vec<(String, Bsdf)> {
    let mut random = Random(1);
    let mut all: Vec<(String, Bsdf)> = Fold::ALL
        .into_iter()
        .map(|fold| {
            let table = table(fold, false, &mut random);
            (format!("{fold:?}"), of(vec![Component::new(Side::Front, Side::Front, table)]))
        })
        .collect();
    let lone = table(Fold::MirrorY, false, &mut random);
    let both = table(Fold::MirrorY, false, &mut random).with_reverse(table(
        Fold::MirrorX,
        false,
        &mut random,
    ));
    let back = |table| of(vec![Component::new(Side::Back, Side::Front, table)]);
    all.push(("in reverse, by a stand-in".into(), back(lone)));
    all.push(("in reverse".into(), back(both)));
    let mixture = Bsdf::new(
        Metadata::default(),
        vec![
            Component::new(Side::Front, Side::Front, table(Fold::None, true, &mut random)),
            Component::new(Side::Front, Side::Back, table(Fold::Isotropic, false, &mut random)),
        ],
        Lambertian { reflection_front: Xyz::grey(0.2), ..Lambertian::default() },
    );
    all.push(("mixture".into(), mixture));
    all
}

const INCIDENCES: [(f64, f64); 2] = [(33.0, 70.0), (71.0, 201.0)];

/// Cells of the square per side and hemisphere, and points across each.
const GRID: usize = 12;
const ACROSS: usize = 24;

fn bin(w: DVec3) -> usize {
    let s = hemisphere_to_square(w) * GRID as f64;
    let cell = |c: f64| (c as usize).min(GRID - 1);
    usize::from(Side::of(w) == Side::Back) * GRID * GRID + cell(s.y) * GRID + cell(s.x)
}

/// ∫ over each bin of what `f` says of a direction, per projected solid angle.
fn integrals(f: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let steps = GRID * ACROSS;
    let mut sums = vec![0.0; 2 * GRID * GRID];
    for side in [Side::Front, Side::Back] {
        for k in 0..steps * steps {
            let at = DVec2::new((k % steps) as f64 + 0.5, (k / steps) as f64 + 0.5);
            let w = square_to_hemisphere(at / steps as f64, side);
            sums[bin(w)] += f(w) * PI / (steps * steps) as f64;
        }
    }
    sums
}

#[test]
fn samples_follow_their_density_whose_integral_is_one() {
    let cases = cases();
    let level = chi_squared::level(cases.len() * INCIDENCES.len() * 2);
    let mut random = Random(2);
    for (name, bsdf) in &cases {
        for (theta, phi) in INCIDENCES {
            let wi = from_degrees(theta, phi);
            let pdf = |w: DVec3| bsdf.pdf(wi, w, Components::ALL) / w.z.abs();
            let expected = integrals(pdf);
            let sum: f64 = expected.iter().sum();
            assert!((sum - 1.0).abs() < 0.01, "{name} {theta}: pdf integrates to {sum}");
            for two in [false, true] {
                let draws = 20_000;
                let mut observed = vec![0.0; expected.len()];
                for _ in 0..draws {
                    let u = DVec2::new(random.unit(), random.unit());
                    let sample = match two {
                        true => bsdf.sample2(wi, u, Components::ALL),
                        false => bsdf.sample(wi, u.x, Components::ALL),
                    };
                    let sample = sample.expect("light");
                    observed[bin(sample.wo)] += 1.0;
                    let pdf = bsdf.pdf(wi, sample.wo, Components::ALL);
                    assert!((sample.pdf / pdf - 1.0).abs() < 1e-9, "{name}: {sample:?} {pdf}");
                    let both = bsdf.eval_pdf(wi, sample.wo, Components::ALL);
                    let f = bsdf.eval(wi, sample.wo);
                    let off = (both.0 / f - 1.0, both.1 / pdf - 1.0);
                    assert!(off.0.abs() < 1e-12 && off.1.abs() < 1e-12, "{name}: {off:?}");
                    let weight = f * sample.wo.z.abs() / sample.pdf;
                    assert!((weight - sample.weight).abs() <= 1e-9 * weight, "{name}: {sample:?}");
                }
                let expected: Vec<f64> =
                    expected.iter().map(|e| e / sum * f64::from(draws)).collect();
                let name = format!("{name}, {theta} degrees, two numbers: {two}");
                chi_squared::expect(&name, &observed, &expected, level);
            }
        }
    }
}

#[test]
fn weights_have_the_mean_that_values_have() {
    for (name, bsdf) in &cases() {
        for (theta, phi) in &INCIDENCES {
            let wi = from_degrees(*theta, *phi);
            let total: f64 = integrals(|w| bsdf.eval(wi, w)).iter().sum();
            // A stand-in adds up its total each time.
            let draws = if name.contains("stand-in") { 4_000 } else { 40_000 };
            let weight = |n: i32| {
                let u = (f64::from(n) + 0.5) / f64::from(draws);
                bsdf.sample(wi, u, Components::ALL).map_or(0.0, |s| s.weight)
            };
            let mean = (0..draws).map(weight).sum::<f64>() / f64::from(draws);
            assert!((mean / total - 1.0).abs() < 0.05, "{name} {theta}: {mean} {total}");
        }
    }
}

#[test]
fn neighbouring_numbers_give_neighbouring_directions() {
    // Of one layer, as tables of several have one curve each.
    let mut random = Random(5);
    let chart = Chart::new(Fold::None, 2, 1.0).unwrap();
    let nodes = chart.nodes();
    let content = Content {
        values: vec![1.0; nodes * 8 * 7],
        density: (0..nodes * 7 * 9).map(|_| 1.0 + random.unit()).collect(),
        ..Content::default()
    };
    let layer = Layer::new(&chart, shape(FrameKind::Slopes, false), &content).unwrap();
    let fine = chart.refined(2).nodes();
    let poses = vec![vec![Pose::about_normal(1.0); fine]];
    let table = RenderTable::new(chart, vec![layer], &poses).unwrap();
    let table = table.with_energy(&vec![1.0; fine], &vec![1.0; fine]).unwrap();
    let bsdf = of(vec![Component::new(Side::Front, Side::Front, table)]);
    let wi = from_degrees(30.0, 20.0);
    let at = |n: i32| {
        let u = (f64::from(n) + 0.5) / 4096.0;
        bsdf.sample(wi, u, Components::ALL).unwrap().wo
    };
    let mut steps: Vec<f64> = (0..4095).map(|n| at(n).distance(at(n + 1))).collect();
    steps.sort_by(f64::total_cmp);
    // 4096 directions stand about 0.03 apart.
    assert!(steps[2047] < 0.05 && steps[4000] < 0.3, "{} {}", steps[2047], steps[4000]);
}

#[test]
fn files_keep_every_bit_however_they_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    for (n, (name, bsdf)) in cases().into_iter().enumerate() {
        let path = folder.path().join(format!("{n}.safetensors"));
        container::save(&bsdf, &path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes, container::to_bytes(&bsdf).unwrap(), "{name}");
        let opened = [
            container::open(&path).unwrap(),
            container::load(&path).unwrap(),
            container::from_bytes(&bytes).unwrap(),
        ];
        let mut random = Random(3);
        for _ in 0..200 {
            let side = |random: &mut Random| {
                if random.unit() < 0.5 { Side::Front } else { Side::Back }
            };
            let (a, b) = (side(&mut random), side(&mut random));
            let (wi, wo, u) = (random.direction(a), random.direction(b), random.unit());
            for other in &opened {
                assert_eq!(bsdf.eval_xyz(wi, wo), other.eval_xyz(wi, wo), "{name}");
                let drawn = |b: &Bsdf| b.sample(wi, u, Components::ALL);
                assert_eq!(drawn(&bsdf), drawn(other), "{name}");
                let total = |b: &Bsdf| b.directional_hemispherical(wi, Components::ALL);
                assert_eq!(total(&bsdf), total(other), "{name}");
                let psa = |b: &Bsdf| b.projected_solid_angle(wi, Some(wo));
                assert_eq!(psa(&bsdf), psa(other), "{name}");
            }
        }
    }
}

/// A table of each fold, in two files of a component for each pair of sides: what device headers are tried with.
fn golden() -> [(&'static str, Bsdf); 2] {
    let mut random = Random(11);
    let sides = [
        (Side::Front, Side::Front),
        (Side::Front, Side::Back),
        (Side::Back, Side::Front),
        (Side::Back, Side::Back),
    ];
    let mut file = |folds: &[Fold]| {
        let one = |(fold, (from, to)): (&Fold, (Side, Side))| {
            Component::new(from, to, table(*fold, false, &mut random))
        };
        of(folds.iter().zip(sides).map(one).collect())
    };
    [("render_turned", file(&Fold::ALL[..4])), ("render_isotropic", file(&Fold::ALL[4..]))]
}

#[test]
fn golden_files_hold_these_tables() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/compiled");
    for (name, bsdf) in golden() {
        let path = folder.join(format!("{name}.safetensors"));
        if std::env::var_os("BSDFKIT_REMAKE_GOLDEN").is_some() {
            container::save(&bsdf, &path).unwrap();
        }
        let kept = container::load(&path).unwrap();
        let mut random = Random(12);
        for n in 0..400 {
            let [a, b] = [n % 2, n / 2 % 2].map(|k| [Side::Front, Side::Back][k]);
            let (wi, wo) = (random.direction(a), random.direction(b));
            let [f, g] = [&kept, &bsdf].map(|b| b.eval_pdf(wi, wo, Components::ALL));
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs();
            assert!(near(f.0, g.0) && near(f.1, g.1), "{name}: {f:?} {g:?}: see CONTRIBUTING.md");
        }
    }
}

#[test]
fn slices_are_single_queries_bit_for_bit() {
    let mut random = Random(4);
    let mut directions = |count: usize| -> Vec<DVec3> {
        let mut one = |n: usize| match n % 40 {
            0 => DVec3::new(0.0, f64::NAN, 1.0),
            1 => [DVec3::Z, DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.8, 0.001)][n / 40 % 4],
            n => random.direction(if n % 3 == 0 { Side::Back } else { Side::Front }),
        };
        (0..count).map(&mut one).collect()
    };
    let (wi, wo) = (directions(1501), directions(1501));
    let u: Vec<f64> = (0..wi.len()).map(|n| n as f64 / wi.len() as f64).collect();
    let bits = |x: f64| if x.is_nan() { f64::NAN } else { x }.to_bits();
    for (name, bsdf) in &cases() {
        let (mut f, mut pdf) = (vec![0.0; wi.len()], vec![0.0; wi.len()]);
        let (mut both, mut samples) = (vec![[0.0; 2]; wi.len()], vec![None; wi.len()]);
        bsdf.eval_many(&wi, &wo, &mut f).unwrap();
        bsdf.pdf_many(&wi, &wo, Components::ALL, &mut pdf).unwrap();
        bsdf.eval_pdf_many(&wi, &wo, Components::ALL, &mut both).unwrap();
        bsdf.sample_many(&wi, &u, Components::ALL, &mut samples).unwrap();
        for n in 0..wi.len() {
            let pair = format!("{name}: {} {}", wi[n], wo[n]);
            assert_eq!(bits(f[n]), bits(bsdf.eval(wi[n], wo[n])), "{pair}");
            assert_eq!(bits(pdf[n]), bits(bsdf.pdf(wi[n], wo[n], Components::ALL)), "{pair}");
            let single = bsdf.eval_pdf(wi[n], wo[n], Components::ALL);
            assert_eq!(both[n].map(bits), [bits(single.0), bits(single.1)], "{pair}");
            assert_eq!(samples[n], bsdf.sample(wi[n], u[n], Components::ALL), "{pair}");
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let (_, bsdf) = cases().pop().unwrap();
    let count = 3 * bsdfkit::batch::PARALLEL;
    let mut random = Random(8);
    let wi: Vec<DVec3> = (0..count).map(|_| random.direction(Side::Front)).collect();
    let wo: Vec<DVec3> = (0..count).map(|_| random.direction(Side::Back)).collect();
    let u: Vec<DVec2> = wi.iter().map(|_| DVec2::new(random.unit(), random.unit())).collect();
    let answers = [1, 2, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (mut values, mut both) = (vec![0.0; count], vec![[0.0; 2]; count]);
            let mut samples = vec![None; count];
            bsdf.eval_many(&wi, &wo, &mut values).unwrap();
            bsdf.eval_pdf_many(&wi, &wo, Components::ALL, &mut both).unwrap();
            bsdf.sample2_many(&wi, &u, Components::ALL, &mut samples).unwrap();
            let bits = |x: &f64| x.to_bits();
            let values: Vec<u64> = values.iter().chain(both.as_flattened()).map(bits).collect();
            (values, samples)
        })
    });
    assert!(answers[0] == answers[1] && answers[1] == answers[2]);
}

#[test]
fn hard_directions_and_damaged_files_break_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let hard = [0.0, 1.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY, -0.5];
    let look = |bsdf: &Bsdf| {
        let up = DVec3::new(0.6, 0.0, 0.8);
        for (x, y, z) in hard.iter().flat_map(|x| hard.iter().map(move |y| (*x, *y, 0.3 * x + y))) {
            let w = DVec3::new(x, y, z);
            for (wi, wo) in [(w, up), (up, w), (w, w), (w, -w)] {
                let (f, pdf) = (bsdf.eval(wi, wo), bsdf.pdf(wi, wo, Components::ALL));
                let nan = wi.is_nan() || wo.is_nan();
                assert!(!nan || f.is_nan() && pdf.is_nan(), "{wi} {wo}: {f} {pdf}");
                bsdf.projected_solid_angle(wi, Some(wo));
                bsdf.projected_solid_angle(wi, None);
                bsdf.directional_hemispherical(wi, Components::ALL);
                for u in [0.0, 0.5, 1.0, x] {
                    bsdf.sample(wi, u, Components::ALL);
                    bsdf.sample2(wi, DVec2::new(u, y), Components::ALL);
                }
            }
        }
    };
    let mut random = Random(6);
    for (n, (_, bsdf)) in cases().into_iter().enumerate() {
        look(&bsdf);
        let bytes = container::to_bytes(&bsdf).unwrap();
        for round in 0..20 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + round * 20 {
                let at = (random.next() % damaged.len() as u64) as usize;
                damaged[at] = random.next() as u8;
            }
            if round % 4 == 0 {
                damaged.truncate((random.next() % damaged.len() as u64) as usize);
            }
            let path = folder.path().join(format!("{n}-{round}.safetensors"));
            std::fs::write(&path, &damaged).unwrap();
            if let Ok(bsdf) = container::open(&path) {
                look(&bsdf);
            }
            let _ = container::load(&path);
        }
    }
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let bsdf = of(vec![Component::new(
        Side::Front,
        Side::Front,
        table(Fold::Quadrants, true, &mut Random(7)),
    )]);
    let bytes = container::to_bytes(&bsdf).unwrap();
    let text = String::from_utf8_lossy(&bytes[8..]);
    let header = &text[..text.find("}}").unwrap()];
    for (what, with) in [
        (r#"\"intervals\":3"#, r#"\"intervals\":4"#),
        (r#"\"intervals\":3"#, r#"\"intervals\":0"#),
        (r#"\"angles\":7"#, r#"\"angles\":8"#),
        (r#"\"drawn_radii\":8"#, r#"\"drawn_radii\":7"#),
        (r#"\"core\":0.1"#, r#"\"core\":0.0"#),
        (r#"\"grazing\":1.0"#, r#"\"grazing\":-1."#),
    ] {
        assert!(header.contains(what), "{what}: {header}");
        let changed = bytes.windows(what.len()).position(|w| w == what.as_bytes()).unwrap();
        let mut bad = bytes.clone();
        bad[changed..changed + with.len()].copy_from_slice(with.as_bytes());
        let error = container::from_bytes(&bad).expect_err(what);
        assert_eq!(error.class(), bsdfkit::ErrorClass::Format, "{what}: {error}");
    }
}

/// Found by `container_parts`: such a factor made values negative, such a total light less than none.
#[test]
fn negative_energy_is_refused() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/golden/compiled/render_isotropic.safetensors");
    let sound = std::fs::read(&path).unwrap();
    let header = u64::from_le_bytes(sound[..8].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&sound[8..8 + header]).unwrap();
    let array = &json["component.0.render.incidences"];
    let columns = array["shape"][1].as_u64().unwrap() as usize;
    let first = 8 + header + array["data_offsets"][0].as_u64().unwrap() as usize;
    let folder = tempfile::tempdir().unwrap();
    // The first node's total; the last number of its last layer, the factor.
    for column in [0, columns - 1] {
        for wrong in [-1.0_f32, f32::NAN, f32::INFINITY] {
            let mut bytes = sound.clone();
            bytes[first + 4 * column..][..4].copy_from_slice(&wrong.to_le_bytes());
            let path = folder.path().join("damaged.safetensors");
            std::fs::write(&path, bytes).unwrap();
            let error = container::load(&path).unwrap_err().to_string();
            assert!(error.contains("of at least 0"), "{column}: {error}");
        }
    }
}
