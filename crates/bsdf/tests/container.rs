//! The container gives back what was put in, bit for bit, and refuses everything else.

mod support;

use std::path::Path;

use bsdfkit::container::{from_bytes, load, open, save, to_bytes};
use bsdfkit::tree::{Rank, TensorTree, TreeDistribution};
use bsdfkit::{Bsdf, Component, Components, ErrorClass, Lambertian, Metadata, Side, Xyz, xml};
use support::{Random, random_tree};

fn golden() -> impl Iterator<Item = (String, Bsdf)> {
    let names = [
        "t4_rf_rb_tf_tb.xml",
        "t3_tb.xml",
        "color_tree_0.6_0.3.xml",
        "color_mtx_0.6_0.3.xml",
        "custom_basis.xml",
        "mixed_basis.xml",
        "kf_in_tf.xml",
        "meta_1.xml",
        "diffuse_pure.xml",
    ];
    names.into_iter().map(|name| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/xml");
        (name.to_owned(), xml::read(folder.join(name)).expect(name))
    })
}

fn small() -> Bsdf {
    let tree = |rank, seed| TreeDistribution::new(random_tree(rank, 2, 0.0, &mut Random(seed)));
    Bsdf::new(
        Metadata { name: "spécimen".into(), thickness: 0.003, ..Metadata::default() },
        vec![
            Component::new(Side::Front, Side::Front, tree(Rank::Four, 1)),
            Component::new(Side::Back, Side::Front, tree(Rank::Three, 2)),
            Component::new(
                Side::Back,
                Side::Back,
                TreeDistribution::new(TensorTree::constant(Rank::Four, 0.1).unwrap()),
            ),
        ],
        Lambertian { reflection_front: Xyz::new(0.1, 0.2, 0.3), ..Lambertian::default() },
    )
}

#[test]
fn answers_are_the_same_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    for (name, ours) in golden().chain([("small".to_owned(), small())]) {
        let path = folder.path().join(format!("{name}.safetensors"));
        save(&ours, &path).expect(&name);
        for theirs in [load(&path).expect(&name), open(&path).expect(&name)] {
            assert_eq!(ours.metadata(), theirs.metadata(), "{name}");
            assert_eq!(ours.lambertian(), theirs.lambertian(), "{name}");
            assert_eq!(to_bytes(&ours).unwrap(), to_bytes(&theirs).unwrap(), "{name}");
            let mut random = Random(9);
            for k in 0..400 {
                let side = |bit: u32| if k >> bit & 1 == 0 { Side::Front } else { Side::Back };
                let (wi, wo) = (random.direction(side(0)), random.direction(side(1)));
                assert_eq!(ours.eval_xyz(wi, wo), theirs.eval_xyz(wi, wo), "{name}");
                let u = random.unit();
                let draw = |b: &Bsdf| b.sample(wi, u, Components::ALL);
                assert_eq!(draw(&ours), draw(&theirs), "{name}");
            }
        }
    }
}

#[test]
fn a_failed_save_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let error = save(&small(), folder.path().join("none/there.safetensors")).unwrap_err();
    assert_eq!(error.class(), ErrorClass::Io);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    assert_eq!(load(folder.path()).unwrap_err().class(), ErrorClass::Io);
}

#[test]
fn truncated_files_are_format_errors() {
    let bytes = to_bytes(&small()).unwrap();
    for length in (0..bytes.len()).step_by(7) {
        let error = from_bytes(&bytes[..length]).unwrap_err();
        assert_eq!(error.class(), ErrorClass::Format, "{length}: {error}");
    }
}

/// Any byte may change: the result is an error or a BSDF that answers, never a panic or a hang.
#[test]
fn damaged_files_do_no_harm() {
    let bytes = to_bytes(&small()).unwrap();
    let mut random = Random(4);
    let (mut refused, mut accepted) = (0, 0);
    for _ in 0..3000 {
        let mut damaged = bytes.clone();
        for _ in 0..1 + random.next() % 3 {
            let at = random.next() as usize % damaged.len();
            damaged[at] = random.next() as u8;
        }
        match from_bytes(&damaged) {
            Err(error) => {
                assert_eq!(error.class(), ErrorClass::Format, "{error}");
                refused += 1;
            }
            Ok(bsdf) => {
                let wi = random.direction(Side::Front);
                let total = bsdf.directional_hemispherical(wi, Components::ALL);
                assert!(total >= 0.0, "{total}");
                bsdf.sample(wi, 0.4, Components::ALL);
                accepted += 1;
            }
        }
    }
    assert!(refused > 500 && accepted > 500, "{refused} refused, {accepted} accepted");
}

#[test]
fn flat_trees_are_checked() {
    let refused = |root: u32, slots: Vec<u32>| {
        TensorTree::from_slots(Rank::Three, root, slots).unwrap_err().to_string()
    };
    const BRANCH: u32 = 1 << 31;
    let leaves = vec![0; 8];
    assert!(TensorTree::from_slots(Rank::Three, BRANCH, leaves.clone()).is_ok());
    assert!(refused(BRANCH, vec![0; 7]).contains("found 7 slots"));
    assert!(refused(0, leaves.clone()).contains("branch 0 belongs to no other"));
    assert!(refused(BRANCH | 1, leaves.clone()).contains("branch 1 is missing"));
    assert!(refused(f32::NAN.to_bits() & !BRANCH, vec![]).contains("finite"));
    // A branch that is its own child, then two that share one.
    assert!(refused(BRANCH, vec![BRANCH; 8]).contains("branch 0 is missing, out of order"));
    let mut shared = vec![0; 16];
    (shared[0], shared[1]) = (BRANCH | 1, BRANCH | 1);
    assert!(refused(BRANCH, shared).contains("used twice"));
    // 17 levels.
    let mut chain = vec![0; 17 * 8];
    (0..16).for_each(|p| chain[p * 8] = BRANCH | (p as u32 + 1));
    assert!(refused(BRANCH, chain).contains("deeper than 16"));
}

/// Whatever byte is wrong, opening or querying ends, and without a panic.
#[test]
fn a_damaged_file_that_opens_answers_something() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.safetensors");
    let (_, coloured) = golden().nth(2).unwrap();
    let mut opened = 0;
    let tree = TreeDistribution::new(random_tree(Rank::Four, 4, 0.0, &mut Random(30)));
    let lone = Component::new(Side::Back, Side::Front, tree);
    let lone = Bsdf::new(Metadata::default(), vec![lone], Lambertian::default());
    for bsdf in [lone, coloured] {
        let sound = to_bytes(&bsdf).unwrap();
        let header = 8 + u64::from_le_bytes(*sound.first_chunk().unwrap()) as usize;
        let mut random = Random(31);
        for _ in 0..400 {
            let mut bytes = sound.clone();
            for _ in 0..1 + random.next() % 40 {
                let at = header + random.next() as usize % (bytes.len() - header);
                bytes[at] = random.next() as u8;
            }
            std::fs::write(&path, &bytes).unwrap();
            let Ok(bsdf) = open(&path) else { continue };
            opened += 1;
            let mut random = Random(32);
            let side = |n: u64| if n.is_multiple_of(2) { Side::Front } else { Side::Back };
            let direction = |r: &mut Random| r.direction(side(r.0));
            let wi: Vec<_> = (0..64).map(|_| direction(&mut random)).collect();
            let wo: Vec<_> = (0..64).map(|_| direction(&mut random)).collect();
            let u: Vec<f64> = (0..64).map(|_| random.unit()).collect();
            let (mut values, mut samples) = (vec![0.0; 64], vec![None; 64]);
            bsdf.eval_many(&wi, &wo, &mut values).unwrap();
            bsdf.pdf_many(&wi, &wo, Components::ALL, &mut values).unwrap();
            bsdf.sample_many(&wi, &u, Components::ALL, &mut samples).unwrap();
            for k in 0..64 {
                bsdf.eval_xyz(wi[k], wo[k]);
                bsdf.sample(wi[k], u[k], Components::ALL);
                bsdf.projected_solid_angle(wi[k], None);
            }
        }
    }
    assert!(opened > 100, "only {opened} of 800 damaged files open: nothing is tested");
}
