//! Prints a BSDF's answers, as examples/README.md lays down.

use std::io::{self, BufWriter, Write};
use std::process::ExitCode;

use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::render::RenderTable;
use bsdfkit::tree::{Rank, TreeDistribution};
use bsdfkit::{Bsdf, Component, Components, DVec2, DVec3, ErrorClass, Part, Sample, Side};
use bsdfkit_fit::open;

const INCIDENT: [([f64; 3], f64); 5] = [
    ([-2.0, 3.0, 6.0], 7.0),
    ([6.0, -2.0, 3.0], 7.0),
    ([-8.0, -1.0, 4.0], 9.0),
    ([0.0, 0.0, 1.0], 1.0),
    ([3.0, -4.0, 12.0], 13.0),
];
const SCATTERED: [([f64; 3], f64); 5] = [
    ([2.0, -3.0, 6.0], 7.0),
    ([1.0, 2.0, 2.0], 3.0),
    ([-4.0, 4.0, 7.0], 9.0),
    ([6.0, 2.0, 9.0], 11.0),
    ([-2.0, -6.0, 3.0], 7.0),
];
const SAMPLES: u8 = 12;

fn directions(table: [([f64; 3], f64); 5]) -> Vec<DVec3> {
    let front = table.map(|(v, length)| DVec3::from(v) / length);
    let back = front.map(|w| DVec3::new(w.x, w.y, -w.z));
    [front, back].concat()
}

/// C's `%.6e`.
fn real(x: f64) -> String {
    let text = format!("{x:.6e}");
    match text.split_once('e') {
        None => text,
        Some((digits, exponent)) => {
            let exponent: i32 = exponent.parse().expect("digits");
            let sign = if exponent < 0 { '-' } else { '+' };
            format!("{digits}e{sign}{:02}", exponent.abs())
        }
    }
}

fn side(side: Side) -> &'static str {
    match side {
        Side::Front => "front",
        Side::Back => "back",
    }
}

fn representation(component: &Component) -> &'static str {
    let distribution = component.distribution();
    if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
        return match tree.luminance().rank() {
            Rank::Three => "tree3",
            Rank::Four => "tree4",
        };
    }
    let matrix = distribution.downcast_ref::<KlemsMatrix>();
    match (matrix, distribution.downcast_ref::<RenderTable>()) {
        (Some(_), _) => "matrix",
        (_, Some(_)) => "render",
        (None, None) => "continuous",
    }
}

fn sample(sample: Option<Sample>) -> String {
    let Some(Sample { wo, weight, pdf, part }) = sample else { return "none".into() };
    let part = match part {
        Part::LambertianReflection => "lambertian_reflection".into(),
        Part::LambertianTransmission => "lambertian_transmission".into(),
        Part::Component(n) => format!("component {n}"),
        Part::Specular(n) => format!("specular {n}"),
    };
    let [x, y, z, weight, pdf] = [wo.x, wo.y, wo.z, weight, pdf].map(real);
    format!("{x} {y} {z} {weight} {pdf} {part}")
}

fn print(bsdf: &Bsdf, out: &mut impl Write) -> io::Result<()> {
    let metadata = bsdf.metadata();
    writeln!(out, "name {}", metadata.name)?;
    writeln!(out, "manufacturer {}", metadata.manufacturer)?;
    let size = [metadata.width, metadata.height, metadata.thickness].map(real);
    writeln!(out, "size {}", size.join(" "))?;
    for (n, c) in bsdf.components().iter().enumerate() {
        let (incident, scattered) = (side(c.incident), side(c.scattered));
        writeln!(out, "component {n} {incident} {scattered} {}", representation(c))?;
    }
    let (front, back) = (Side::Front, Side::Back);
    let pairs = [(front, front), (back, back), (front, back), (back, front)];
    let lambertian = pairs.map(|(from, to)| real(bsdf.lambertian().get(from, to).y));
    writeln!(out, "lambertian {}", lambertian.join(" "))?;

    let (incident, scattered) = (directions(INCIDENT), directions(SCATTERED));
    let all = Components::ALL;
    let pairs = || {
        let with = |(i, wi): (usize, DVec3)| {
            scattered.iter().copied().enumerate().map(move |(j, wo)| (i, wi, j, wo))
        };
        incident.iter().copied().enumerate().flat_map(with)
    };
    for (i, wi, j, wo) in pairs() {
        writeln!(out, "eval {i} {j} {}", real(bsdf.eval(wi, wo)))?;
    }
    for (i, wi, j, wo) in pairs() {
        writeln!(out, "pdf {i} {j} {}", real(bsdf.pdf(wi, wo, all)))?;
    }
    for (i, wi, j, wo) in pairs() {
        let (value, pdf) = bsdf.eval_pdf(wi, wo, all);
        writeln!(out, "eval_pdf {i} {j} {} {}", real(value), real(pdf))?;
    }
    for (i, wi, j, wo) in pairs() {
        let (least, most) = bsdf.projected_solid_angle(wi, Some(wo));
        writeln!(out, "projected_solid_angle {i} {j} {} {}", real(least), real(most))?;
    }
    for (i, &wi) in incident.iter().enumerate() {
        let ways = [all, Components::REFLECTION, Components::TRANSMISSION];
        let totals = ways.map(|way| real(bsdf.directional_hemispherical(wi, way)));
        writeln!(out, "hemispherical {i} {}", totals.join(" "))?;
    }
    for (i, &wi) in incident.iter().enumerate() {
        let (least, most) = bsdf.projected_solid_angle(wi, None);
        writeln!(out, "projected_solid_angle {i} {} {}", real(least), real(most))?;
    }
    for (i, &wi) in incident.iter().enumerate() {
        for k in 0..SAMPLES {
            let u = (f64::from(k) + 0.5) / f64::from(SAMPLES);
            writeln!(out, "sample {i} {k} {}", sample(bsdf.sample(wi, u, all)))?;
        }
    }
    for (i, &wi) in incident.iter().enumerate() {
        for k in 0..SAMPLES {
            let u = DVec2::new(f64::from(k) + 0.5, f64::from(5 * k % SAMPLES) + 0.5);
            let u = u / f64::from(SAMPLES);
            writeln!(out, "sample2 {i} {k} {}", sample(bsdf.sample2(wi, u, all)))?;
        }
    }
    out.flush()
}

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1) else {
        eprintln!("usage: parity FILE");
        return ExitCode::from(2);
    };
    let bsdf = match open::bsdf(path.as_ref()) {
        Ok(bsdf) => bsdf,
        Err(error) => {
            let class = match error.class() {
                ErrorClass::Io => "io",
                ErrorClass::Format => "format",
                ErrorClass::Argument => "argument",
                ErrorClass::Limit => "limit",
            };
            eprintln!("parity: {class}: {error}");
            return ExitCode::FAILURE;
        }
    };
    match print(&bsdf, &mut BufWriter::new(io::stdout().lock())) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("parity: io: standard output: {error}");
            ExitCode::FAILURE
        }
    }
}
