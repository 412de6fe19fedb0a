//! The tables: the warp, and f cos θo over warped half vectors at every incidence.

use std::sync::atomic::AtomicUsize;

use bsdfkit::{Bsdf, Component, Error, Result, Side, Xyz};
use bsdfkit_sphere::direction::from_degrees;
use bsdfkit_sphere::{DVec2, DVec3};

use super::half_vector::{Reflected, reflected};
use super::resolution::Resolution;
use super::spectrum::Channels;
use super::warp::Warp;
use crate::watch::Watch;

/// Share of the warp, in means of its density, that is spread evenly: so no part of the square lacks cells. Between 0.03
/// and 0.3 L1 of rough metal hardly changes.
const EVEN: f64 = 0.03;

/// Points a node along each side, of which the density is the mean.
const POINTS: usize = 2;

/// Most that light is balanced by: what is further off is coarse, and no factor mends it.
const MOST: f64 = 0.1;

/// What is written.
pub(super) struct Tables {
    /// Density of the warp at its nodes.
    pub(super) warp: Vec<f32>,
    /// By azimuth, polar angle, row, column: in proportion to the light of a node's cell.
    pub(super) luminance: Vec<f32>,
    /// By azimuth, polar angle, channel, row, column: f cos θo, 1/sr.
    pub(super) values: Vec<f32>,
    pub(super) channels: usize,
    /// nm; none of RGB.
    pub(super) wavelengths: Vec<f32>,
    /// Whether the source has colour.
    pub(super) coloured: bool,
}

/// What a file leaves out.
///
/// Errors: argument, where the front reflects nothing.
pub(super) fn left_out(bsdf: &Bsdf) -> Result<Vec<String>> {
    let front = (Side::Front, Side::Front);
    // A block of zeros, as some programs want it, is nothing.
    let scatters = |c: &&Component| !(c.is_negligible() && c.floor() == Xyz::ZERO);
    let all = || bsdf.components().iter().filter(scatters);
    let stored = all().filter(|c| (c.incident, c.scattered) == front);
    if stored.count() == 0 && bsdf.lambertian().reflection_front == Xyz::ZERO {
        let text = "expected reflection of the front, found none: RGL's form holds nothing else";
        return Err(Error::argument(text));
    }
    let mut lost = Vec::new();
    let pairs = [
        (Side::Back, Side::Back, "reflection of the back"),
        (Side::Front, Side::Back, "transmission from the front"),
        (Side::Back, Side::Front, "transmission from the back"),
    ];
    for (from, to, name) in pairs {
        let has = all().any(|c| (c.incident, c.scattered) == (from, to));
        if has || bsdf.lambertian().get(from, to) != Xyz::ZERO {
            lost.push(name);
        }
    }
    if !bsdf.specular().is_empty() {
        lost.push("peaks of no width");
    }
    lost.extend(bsdf.bands().iter().map(|b| b.name.as_str()));
    let said = match lost.is_empty() {
        true => Vec::new(),
        false => vec![format!("left out: {}", lost.join(", "))],
    };
    Ok(said)
}

/// Directions of one incidence and f there.
struct Scan<'a> {
    bsdf: &'a Bsdf,
    coloured: bool,
    reflected: Vec<Reflected>,
    wo: Vec<DVec3>,
    colours: Vec<Xyz>,
    values: Vec<f64>,
}

impl Scan<'_> {
    /// f cos θo at points of the square, in colour where there is one.
    fn at(&mut self, wi: DVec3, azimuth: f64, points: impl Iterator<Item = DVec2>) -> Result<()> {
        self.reflected.clear();
        self.reflected.extend(points.map(|p| reflected(p, wi, azimuth)));
        self.wo.clear();
        self.wo.extend(self.reflected.iter().map(|r| r.wo));
        self.colours.resize(self.wo.len(), Xyz::ZERO);
        if self.coloured {
            self.bsdf.eval_xyz_many(&[wi], &self.wo, &mut self.colours)?;
        } else {
            self.values.resize(self.wo.len(), 0.0);
            self.bsdf.eval_many(&[wi], &self.wo, &mut self.values)?;
            for (c, v) in self.colours.iter_mut().zip(&self.values) {
                *c = Xyz::grey(*v);
            }
        }
        for (c, r) in self.colours.iter_mut().zip(&self.reflected) {
            // Below the horizon f is that of transmission.
            *c = *c * r.wo.z.max(0.0);
        }
        Ok(())
    }
}

impl Tables {
    /// Errors: limit when cancelled.
    pub(super) fn new(
        bsdf: &Bsdf,
        channels: Channels,
        resolution: &Resolution,
        watch: &Watch<'_>,
    ) -> Result<Self> {
        let coloured = bsdf.components().iter().any(|c| c.distribution().is_coloured())
            || !is_grey(bsdf.lambertian().reflection_front);
        let mut scan = Scan {
            bsdf,
            coloured,
            reflected: Vec::new(),
            wo: Vec::new(),
            colours: Vec::new(),
            values: Vec::new(),
        };
        let isotropic = resolution.phis.len() == 1;
        let incidences: Vec<(DVec3, f64)> = resolution
            .phis
            .iter()
            .flat_map(|phi| resolution.thetas.iter().map(move |theta| (*theta, *phi)))
            .map(|(theta, phi)| {
                (from_degrees(theta, phi), if isotropic { phi.to_radians() } else { 0.0 })
            })
            .collect();
        let (done, jobs) = (AtomicUsize::new(0), 2 * incidences.len());
        let warp = warp_of(&mut scan, &incidences, resolution.warp, |()| {
            watch.finished(&done, jobs);
            watch.check()
        })?;

        let n = resolution.cells;
        let last = (n - 1) as f64;
        // Where nodes are stored is a step function, means about the node; a smooth one is what it is there.
        let offsets: &[f64] = if bsdf.components().iter().any(|c| c.distribution().prepares()) {
            &[0.0]
        } else {
            &[-1.0 / 3.0, 0.0, 1.0 / 3.0]
        };
        let shifts: Vec<DVec2> =
            offsets.iter().flat_map(|y| offsets.iter().map(|x| DVec2::new(*x, *y))).collect();
        let nodes: Vec<(DVec2, f64)> = (0..n * n)
            .flat_map(|k| {
                let node = DVec2::new((k % n) as f64, (k / n) as f64);
                let even =
                    move |shift: &DVec2| ((node + *shift) / last).clamp(DVec2::ZERO, DVec2::ONE);
                shifts.iter().map(even)
            })
            .map(|even| warp.at(even))
            .collect();
        let middles: Vec<(DVec2, f64)> = (0..(n - 1) * (n - 1))
            .map(|k| DVec2::new((k % (n - 1)) as f64 + 0.5, (k / (n - 1)) as f64 + 0.5) / last)
            .map(|even| warp.at(even))
            .collect();
        let wavelengths = channels.wavelengths(coloured);
        let count = if channels == Channels::Rgb { 3 } else { wavelengths.len() };
        let (mut luminance, mut values) = (Vec::new(), Vec::new());
        for &(wi, azimuth) in &incidences {
            watch.check()?;
            scan.at(wi, azimuth, middles.iter().map(|(point, _)| *point))?;
            let truth: Vec<f64> = scan.colours.iter().map(|c| c.y).collect();
            let weight: Vec<f64> =
                scan.reflected.iter().zip(&middles).map(|(r, m)| r.jacobian / m.1).collect();
            scan.at(wi, azimuth, nodes.iter().map(|(point, _)| *point))?;
            let mean = 1.0 / shifts.len() as f64;
            let means: Vec<Xyz> = scan
                .colours
                .chunks(shifts.len())
                .map(|c| c.iter().fold(Xyz::ZERO, |sum, c| sum + *c) * mean)
                .collect();
            let scale = balance(n, &means, &truth, &weight);
            let first = values.len();
            values.resize(first + count * n * n, 0.0);
            let mut sum = 0.0;
            for node in 0..n * n {
                let own = node * shifts.len()..(node + 1) * shifts.len();
                let light: f64 =
                    own.map(|k| scan.colours[k].y * scan.reflected[k].jacobian / nodes[k].1).sum();
                let colour = means[node] * scale;
                for (c, v) in channels.values(colour, coloured).into_iter().enumerate() {
                    values[first + c * n * n + node] = v;
                }
                luminance.push((light * mean) as f32);
                sum += light;
            }
            if sum <= 0.0 {
                // Readers divide by the sum.
                let first = luminance.len() - n * n;
                luminance[first..].fill(1.0);
            }
            watch.finished(&done, jobs);
        }
        let warp = warp.values().iter().map(|v| *v as f32).collect();
        Ok(Self { warp, luminance, values, channels: count, wavelengths, coloured })
    }
}

/// What values at nodes are multiplied by, so that what is linear between them has the light that there is.
///
/// Where f is curved, what is linear errs most in the middle of a cell, on the mean two thirds of that.
fn balance(n: usize, nodes: &[Xyz], truth: &[f64], weight: &[f64]) -> f64 {
    let (mut linear, mut true_) = (0.0, 0.0);
    for (k, (t, w)) in truth.iter().zip(weight).enumerate() {
        let at = k / (n - 1) * n + k % (n - 1);
        let corners = [at, at + 1, at + n, at + n + 1];
        linear += 0.25 * corners.iter().map(|&c| nodes[c].y).sum::<f64>() * w;
        true_ += t * w;
    }
    if linear > 0.0 { 1.0 + 2.0 / 3.0 * (true_ / linear - 1.0).clamp(-MOST, MOST) } else { 1.0 }
}

fn is_grey(c: Xyz) -> bool {
    c.x == c.y && c.y == c.z
}

/// The warp of all incidences together: the root of their light over the square on the mean, and an even share.
fn warp_of(
    scan: &mut Scan<'_>,
    incidences: &[(DVec3, f64)],
    n: usize,
    each: impl Fn(()) -> Result<()>,
) -> Result<Warp> {
    let fine = POINTS * n;
    let points = || {
        (0..fine * fine)
            .map(|k| DVec2::new((k % fine) as f64 + 0.5, (k / fine) as f64 + 0.5) / fine as f64)
    };
    let mut density = vec![0.0; fine * fine];
    for &(wi, azimuth) in incidences {
        scan.at(wi, azimuth, points())?;
        let light = || scan.colours.iter().zip(&scan.reflected).map(|(c, r)| c.y * r.jacobian);
        let sum: f64 = light().sum();
        if sum > 0.0 {
            for (density, light) in density.iter_mut().zip(light()) {
                *density += light / sum;
            }
        }
        each(())?;
    }
    // What is linear between nodes errs least with cells by the root of the light: L1 is a third less than by the light.
    density.iter_mut().for_each(|d| *d = d.sqrt());
    let mean = density.iter().sum::<f64>() / density.len() as f64;
    let (mean, even) = if mean > 0.0 { (mean, EVEN) } else { (1.0, 1.0) };
    let along = |k: usize| {
        // Fine cells about node k, the border's once.
        let centre = k as f64 * fine as f64 / (n - 1) as f64;
        let half = 0.5 * fine as f64 / (n - 1) as f64;
        (((centre - half).max(0.0)) as usize)..(((centre + half).ceil() as usize).min(fine))
    };
    let mut values = vec![0.0; n * n];
    for (k, value) in values.iter_mut().enumerate() {
        let (rows, columns) = (along(k / n), along(k % n));
        let cells = (rows.len() * columns.len()) as f64;
        let row = |y: usize| density[y * fine..][columns.clone()].iter().sum::<f64>();
        *value = rows.map(row).sum::<f64>() / cells / mean + even;
    }
    // The first and the last row are the same azimuth.
    for x in 0..n {
        let both = 0.5 * (values[x] + values[(n - 1) * n + x]);
        (values[x], values[(n - 1) * n + x]) = (both, both);
    }
    Ok(Warp::new(n, values))
}
