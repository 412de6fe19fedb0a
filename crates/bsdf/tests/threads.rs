//! One handle, several threads: the same answers, whoever needs a table first.
//!
//! `make tsan` runs these under ThreadSanitizer.

#[allow(dead_code)] // Other tests use the rest.
mod support;

use std::path::PathBuf;
use std::sync::Barrier;
use std::thread;

use bsdfkit::{Bsdf, Components, DVec3, Sample, Side, Xyz, container, xml};
use support::Random;

/// What needs tables of its own: slices both ways, rings, running sums both ways, colour.
const FILES: [&str; 6] =
    ["t4_rf_rb_tf_tb", "t4_tf", "t3_tf", "kf_in_tf", "color_tree_0.6_0.3", "color_mtx_0.6_0.3"];
const QUERIES: usize = 60;

fn golden(name: &str) -> PathBuf {
    format!("{}/../../tests/golden/xml/{name}.xml", env!("CARGO_MANIFEST_DIR")).into()
}

fn directions(seed: u64) -> Vec<DVec3> {
    let mut random = Random(seed);
    let side = |n: usize| if n.is_multiple_of(2) { Side::Front } else { Side::Back };
    (0..QUERIES).map(|n| random.direction(side(n / 2 + n * seed as usize))).collect()
}

/// The bits of all answers to one query.
type Answer = Vec<u64>;

fn bits(values: impl IntoIterator<Item = f64>) -> Answer {
    values.into_iter().map(f64::to_bits).collect()
}

fn sample_bits(sample: Option<Sample>) -> Answer {
    bits(sample.iter().flat_map(|s| [s.wo.x, s.wo.y, s.wo.z, s.weight, s.pdf]))
}

/// All verbs, the `first` one first: which table is made first depends on it.
fn answer(bsdf: &Bsdf, wi: DVec3, wo: DVec3, u: f64, first: usize) -> Answer {
    let every = Components::ALL;
    let mut answers = vec![Answer::new(); 6];
    for verb in (0..6).map(|n| (first + n) % 6) {
        answers[verb] = match verb {
            0 => sample_bits(bsdf.sample(wi, u, every)),
            1 => bits([bsdf.directional_hemispherical(wi, every)]),
            2 => bits([bsdf.pdf(wi, wo, every)]),
            3 => bits(<[f64; 2]>::from(bsdf.projected_solid_angle(wi, None))),
            4 => bits([bsdf.eval(wi, wo)]),
            _ => {
                let Xyz { x, y, z } = bsdf.eval_xyz(wi, wo);
                bits([x, y, z])
            }
        };
    }
    answers.concat()
}

/// Answers of `threads` threads that begin together, each elsewhere.
fn answers(bsdf: &Bsdf, threads: usize) -> Vec<Vec<Answer>> {
    let (wi, wo) = (directions(1), directions(2));
    let start = Barrier::new(threads);
    let work = |thread: usize| {
        let mut answers = vec![Answer::new(); QUERIES];
        start.wait();
        for k in 0..QUERIES {
            let k = (k + thread * QUERIES / threads) % QUERIES;
            answers[k] = answer(bsdf, wi[k], wo[k], k as f64 / QUERIES as f64, thread);
        }
        answers
    };
    thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|t| scope.spawn(move || work(t))).collect();
        running.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

#[test]
fn first_touches_from_several_threads_at_once() {
    let folder = tempfile::tempdir().unwrap();
    for name in FILES {
        let compiled = folder.path().join("compiled.safetensors");
        let read = xml::read(golden(name)).unwrap();
        let expected = answers(&read, 1).remove(0);
        assert!(expected.iter().flatten().any(|bits| *bits != 0), "{name}");
        container::save(&read, &compiled).unwrap();
        for threads in [1, 2, 4] {
            for _ in 0..4 {
                // Fresh handles: no table is made yet, but for those in the container.
                for fresh in [xml::read(golden(name)).unwrap(), container::open(&compiled).unwrap()]
                {
                    for found in answers(&fresh, threads) {
                        assert_eq!(found, expected, "{name}, {threads} threads");
                    }
                }
            }
        }
    }
}

#[test]
fn batches_from_several_threads_at_once() {
    let (wi, wo, every) = (directions(1), directions(2), Components::ALL);
    let (wi, wo) = (wi.repeat(40), wo.repeat(40));
    let u: Vec<f64> = (0..wi.len()).map(|n| (n as f64 * 0.618).fract()).collect();
    let batches = |bsdf: &Bsdf, samples_first: bool| {
        let mut samples = vec![None; wi.len()];
        let mut values = [(); 3].map(|()| vec![0.0; wi.len()]);
        let mut draw = || bsdf.sample_many(&wi, &u, every, &mut samples).unwrap();
        if samples_first {
            draw();
        }
        let [totals, f, pdf] = &mut values;
        bsdf.directional_hemispherical_many(&wi, every, totals).unwrap();
        bsdf.eval_many(&wi, &wo, f).unwrap();
        bsdf.pdf_many(&wi, &wo, every, pdf).unwrap();
        if !samples_first {
            draw();
        }
        (samples.into_iter().map(sample_bits).collect::<Vec<_>>(), values.map(bits))
    };
    for name in FILES {
        let expected = batches(&xml::read(golden(name)).unwrap(), true);
        for threads in [1, 2, 4] {
            let fresh = xml::read(golden(name)).unwrap();
            let start = Barrier::new(threads);
            let work = |thread: usize| {
                start.wait();
                batches(&fresh, thread.is_multiple_of(2))
            };
            thread::scope(|scope| {
                let running: Vec<_> = (0..threads).map(|t| scope.spawn(move || work(t))).collect();
                for thread in running {
                    assert!(thread.join().unwrap() == expected, "{name}, {threads} threads");
                }
            });
        }
    }
}

#[test]
fn handles_go_where_they_are_needed() {
    fn shared<T: Send + Sync + 'static>(value: T) -> T {
        value
    }
    let expected = answers(&xml::read(golden(FILES[0])).unwrap(), 1).remove(0);
    let bsdf = shared(thread::spawn(|| xml::read(golden(FILES[0])).unwrap()).join().unwrap());
    // Clones share what they hold, and the last one frees it.
    let clones = [bsdf.clone(), bsdf.clone(), bsdf];
    let users: Vec<_> =
        clones.into_iter().map(|b| thread::spawn(move || answers(&b, 1).remove(0))).collect();
    for user in users {
        assert_eq!(user.join().unwrap(), expected);
    }
}
