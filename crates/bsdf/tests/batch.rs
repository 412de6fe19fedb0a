//! Slices answer as single queries do, bit for bit, on any number of threads.

mod support;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::{
    Bsdf, Component, Components, DVec2, DVec3, ErrorClass, Lambertian, Metadata, Sample, Side, Xyz,
};
use support::{Random, random_tree};

fn tree(rank: Rank, depth: u32, floor: f32, seed: u64) -> TreeDistribution {
    TreeDistribution::new(random_tree(rank, depth, floor, &mut Random(seed)))
}

fn matrix(basis: &KlemsBasis, floor: f32, seed: u64) -> KlemsMatrix {
    let mut random = Random(seed);
    let count = basis.directions() * basis.directions();
    let values = (0..count).map(|_| floor + random.unit().powi(4) as f32).collect();
    KlemsMatrix::new(basis.clone(), basis.clone(), values).unwrap()
}

/// Everything that answers in its own way, on all pairs of sides.
fn cases() -> Vec<Bsdf> {
    use Side::{Back, Front};
    let lambertian = Lambertian { reflection_back: Xyz::grey(0.1), ..Lambertian::default() };
    let of = |components| Bsdf::new(Metadata::default(), components, lambertian);
    let rings = KlemsBasis::new(
        "short",
        [(20.0, 3), (60.0, 5)]
            .map(|(upper_degrees, patches)| bsdfkit::matrix::Ring { upper_degrees, patches })
            .into(),
    );
    vec![
        of(vec![
            Component::new(Front, Front, tree(Rank::Four, 4, 0.02, 1)),
            Component::new(Front, Front, tree(Rank::Four, 1, 0.0, 2)),
            Component::new(Back, Front, tree(Rank::Four, 3, 0.01, 3)),
        ]),
        of(vec![
            Component::new(Front, Front, tree(Rank::Three, 4, 0.02, 4)),
            Component::new(Front, Back, tree(Rank::Three, 3, 0.0, 5)),
            Component::new(Back, Front, tree(Rank::Three, 3, 0.0, 6)),
        ]),
        of(vec![
            Component::new(Front, Front, matrix(&KlemsBasis::full(), 0.02, 7)),
            Component::new(Back, Back, matrix(&KlemsBasis::half(), 0.0, 8)),
            Component::new(Back, Front, matrix(&KlemsBasis::quarter(), 0.1, 9)),
            Component::new(Front, Front, matrix(&rings.unwrap(), 0.0, 10)),
        ]),
        of(vec![
            Component::new(Front, Front, matrix(&KlemsBasis::full(), 0.02, 11)),
            Component::new(Front, Front, matrix(&KlemsBasis::full(), 0.0, 12)),
            Component::new(Front, Back, matrix(&KlemsBasis::full(), 0.0, 13)),
        ]),
        of(vec![]),
    ]
}

/// Directions on both sides, with the hard ones among them.
fn directions(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = Random(seed);
    let hard = [
        DVec3::X,
        DVec3::NEG_Y,
        DVec3::new(0.6, 0.8, -0.0),
        DVec3::Z,
        DVec3::NEG_Z,
        DVec3::new(0.0, -0.0, 1.0),
        DVec3::new(0.5, 0.5, 0.5_f64.sqrt()),
        DVec3::new(1.0 + 1e-12, 0.0, 0.0),
        DVec3::NAN,
        DVec3::new(0.0, f64::NAN, 1.0),
        DVec3::new(0.0, 0.0, f64::NAN),
        DVec3::new(f64::INFINITY, 0.0, 1.0),
    ];
    (0..count)
        .map(|_| match random.next() % 50 {
            0 => hard[random.next() as usize % hard.len()],
            n => random.direction(if n % 2 == 0 { Side::Front } else { Side::Back }),
        })
        .collect()
}

const SELECTIONS: [Components; 4] =
    [Components::ALL, Components::LAMBERTIAN, Components::TRANSMISSION, Components::BACK];

fn bits(values: &[f64]) -> Vec<u64> {
    // One NaN is as good as another.
    values.iter().map(|v| if v.is_nan() { f64::NAN } else { *v }.to_bits()).collect()
}

#[test]
fn values_densities_and_totals_equal_single_ones() {
    // One more than whole blocks.
    let (wi, wo) = (directions(3 * 256 + 1, 1), directions(3 * 256 + 1, 2));
    let mut out = vec![0.0; wi.len()];
    let mut sizes = vec![[0.0; 2]; wi.len()];
    for bsdf in cases() {
        let pairs = || wi.iter().zip(&wo).map(|(wi, wo)| (*wi, *wo));
        bsdf.eval_many(&wi, &wo, &mut out).unwrap();
        let single: Vec<f64> = pairs().map(|(wi, wo)| bsdf.eval(wi, wo)).collect();
        assert_eq!(bits(&out), bits(&single));
        for selection in SELECTIONS {
            bsdf.eval_components_many(&wi, &wo, selection, &mut out).unwrap();
            let single: Vec<f64> =
                pairs().map(|(wi, wo)| bsdf.eval_components(wi, wo, selection)).collect();
            assert_eq!(bits(&out), bits(&single));
            bsdf.pdf_many(&wi, &wo, selection, &mut out).unwrap();
            let single: Vec<f64> = pairs().map(|(wi, wo)| bsdf.pdf(wi, wo, selection)).collect();
            assert_eq!(bits(&out), bits(&single));
            bsdf.eval_pdf_many(&wi, &wo, selection, &mut sizes).unwrap();
            for (n, (wi, wo)) in pairs().enumerate() {
                let single: [f64; 2] = bsdf.eval_pdf(wi, wo, selection).into();
                assert_eq!(bits(&sizes[n]), bits(&single));
                let apart = [bsdf.eval_components(wi, wo, selection), bsdf.pdf(wi, wo, selection)];
                assert_eq!(bits(&single), bits(&apart));
            }
            bsdf.directional_hemispherical_many(&wi, selection, &mut out).unwrap();
            let single: Vec<f64> =
                wi.iter().map(|wi| bsdf.directional_hemispherical(*wi, selection)).collect();
            assert_eq!(bits(&out), bits(&single));
        }
        bsdf.projected_solid_angle_many(&wi, None, &mut sizes).unwrap();
        for (size, wi) in sizes.iter().zip(&wi) {
            let single: [f64; 2] = bsdf.projected_solid_angle(*wi, None).into();
            assert_eq!(bits(size), bits(&single));
        }
    }
}

/// Many directions ask for the totals of patches first; those of one side go together.
#[test]
fn totals_of_many_equal_single_ones() {
    let mut wi = directions(3000, 21);
    wi.extend([1e-50, -1e-50, 1e-40, 0.0].map(|z| DVec3::new(0.6, 0.8, z)));
    let (fronts, backs): (Vec<DVec3>, Vec<DVec3>) = wi.iter().partition(|w| w.z > 0.0);
    wi.extend(fronts.iter().chain(&backs));
    for bsdf in cases() {
        for selection in SELECTIONS {
            // Whole chunks, and one more or less.
            for wi in [&wi[..], &fronts, &backs, &wi[..1024], &wi[..1025], &wi[..1087]] {
                let mut out = vec![0.0; wi.len()];
                bsdf.directional_hemispherical_many(wi, selection, &mut out).unwrap();
                let single = wi.iter().map(|wi| bsdf.directional_hemispherical(*wi, selection));
                assert_eq!(bits(&out), bits(&single.collect::<Vec<_>>()));
            }
        }
    }
}

#[test]
fn colours_equal_single_ones() {
    let (wi, wo) = (directions(600, 11), directions(600, 12));
    let golden = |name| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/xml");
        bsdfkit::xml::read(format!("{folder}/{name}.xml")).unwrap()
    };
    let coloured = ["color_tree_0.6_0.3", "color_mtx_0.6_0.3"].map(golden);
    let mut out = vec![Xyz::ZERO; wi.len()];
    let parts = |c: &Xyz| [c.x, c.y, c.z];
    let all = |colours: &[Xyz]| bits(&colours.iter().flat_map(parts).collect::<Vec<_>>());
    for (n, bsdf) in coloured.into_iter().chain(cases()).enumerate() {
        bsdf.eval_xyz_many(&wi, &wo, &mut out).unwrap();
        let single: Vec<Xyz> = wi.iter().zip(&wo).map(|(i, o)| bsdf.eval_xyz(*i, *o)).collect();
        assert_eq!(all(&out), all(&single));
        assert_eq!(out.iter().any(|c| c.x > 1.2 * c.z), n < 2, "the first two are reddish");
        bsdf.eval_xyz_many(&wi[..1], &wo, &mut out).unwrap();
        let single: Vec<Xyz> = wo.iter().map(|o| bsdf.eval_xyz(wi[0], *o)).collect();
        assert_eq!(all(&out), all(&single));
    }
}

#[test]
fn samples_equal_single_ones() {
    let wi = directions(700, 3);
    let mut random = Random(4);
    let u2: Vec<DVec2> = wi.iter().map(|_| DVec2::new(random.unit(), random.unit())).collect();
    let u: Vec<f64> = u2.iter().map(|u| u.x).collect();
    let mut out: Vec<Option<Sample>> = vec![None; wi.len()];
    for bsdf in cases() {
        for selection in SELECTIONS {
            bsdf.sample_many(&wi, &u, selection, &mut out).unwrap();
            for (n, sample) in out.iter().enumerate() {
                assert_eq!(*sample, bsdf.sample(wi[n], u[n], selection));
            }
            bsdf.sample2_many(&wi, &u2, selection, &mut out).unwrap();
            for (n, sample) in out.iter().enumerate() {
                assert_eq!(*sample, bsdf.sample2(wi[n], u2[n], selection));
            }
        }
    }
}

#[test]
fn one_element_counts_for_all() {
    let (wi, wo) = (directions(300, 5), directions(300, 6));
    let bsdf = cases().remove(0);
    let (mut out, mut repeated) = (vec![0.0; 300], vec![0.0; 300]);
    bsdf.eval_many(&wi[..1], &wo, &mut out).unwrap();
    bsdf.eval_many(&[wi[0]; 300], &wo, &mut repeated).unwrap();
    assert_eq!(bits(&out), bits(&repeated));
    bsdf.eval_many(&wi, &wo[..1], &mut out).unwrap();
    bsdf.eval_many(&wi, &[wo[0]; 300], &mut repeated).unwrap();
    assert_eq!(bits(&out), bits(&repeated));
    bsdf.eval_many(&[], &[], &mut []).unwrap();
}

#[test]
fn lengths_are_checked_before_anything_is_written() {
    let wi = directions(4, 7);
    let mut out = [-1.0; 4];
    let e = cases()[0].eval_many(&wi, &wi[..3], &mut out).unwrap_err();
    assert_eq!(e.class(), ErrorClass::Argument);
    assert_eq!(e.to_string(), "wo: expected 4 elements (as many as results) or 1, found 3");
    assert_eq!(out, [-1.0; 4]);
    assert!(cases()[0].sample_many(&wi, &[], Components::ALL, &mut [None; 4]).is_err());
}

/// A fresh handle a pool, so that what is made at the first touch is made by several threads at once.
#[test]
fn any_number_of_threads_gives_the_same() {
    let count = 3 * bsdfkit::batch::PARALLEL;
    let (wi, wo) = (directions(count, 8), directions(count, 9));
    let mut random = Random(10);
    let u: Vec<f64> = wi.iter().map(|_| random.unit()).collect();
    for case in 0..cases().len() {
        let answers = [1, 2, 4].map(|threads| {
            let bsdf = cases().remove(case);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut samples = vec![None; count];
                bsdf.sample_many(&wi, &u, Components::ALL, &mut samples).unwrap();
                let (mut values, mut densities) = (vec![0.0; count], vec![0.0; count]);
                bsdf.eval_many(&wi, &wo, &mut values).unwrap();
                bsdf.pdf_many(&wi, &wo, Components::ALL, &mut densities).unwrap();
                (samples, bits(&values), bits(&densities))
            })
        });
        assert!(answers[0] == answers[1] && answers[1] == answers[2], "case {case}");
    }
}
