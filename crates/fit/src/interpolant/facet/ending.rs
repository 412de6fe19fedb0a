//! Where peaks end that are cut off.
//!
//! Light that leaves a facet at cosine c is reflected by F ≈ exp(−5 c), within 0.03 of Fresnel's
//! equations for n = 1.5 down to the 4 % of the normal. So what is left of a peak says how far it is
//! from total reflection, where c² = 0; and there c² falls by 2 √(n² − 1) / (n cos θ′) a unit of the
//! disk of incident directions (θ′: refraction at the flat entrance), about 1.55 for glass. Of 924 edges
//! across the ends of forty random facets (indices 1.40 to 1.65, tilts 8 to 35 degrees, incidences 15 by 30
//! degrees apart) the place found is off by 0.11 of the edge in the mean, its middle by 0.26. A louvre's
//! edge has no such law; it is found somewhere on its edge of the mesh, too.

use bsdfkit::DVec2;

use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::interpolant::motion::edge_plan::{Cliff, EdgePlan, Pair};
use crate::lobe::{Lobe, LobeSet};

/// How fast the margin c² falls toward total reflection, by unit of the disk.
const RATE: f64 = 1.55;
/// How far below zero, by unit of the disk, the margin is taken to be at a neighbour where the
/// peak is gone: anything from 0 to [`RATE`] is possible. 0.3 is as good.
const BEYOND: f64 = 0.6;
/// Share of a facet's light that it lets through at most.
const CLEAR: f64 = 0.96;
/// Peaks end between this share of an edge and the rest: neither at a measured incidence.
const NEAREST: f64 = 0.05;

/// The margin c² of a peak of which this share of its largest energy is left.
fn margin(left: f64) -> f64 {
    let cosine = (1.0 - CLEAR * left).ln() / 5.0;
    cosine * cosine
}

/// What is known about a mesh whose peaks end.
pub(crate) struct Endings<'a> {
    mesh: &'a IncidenceMesh,
    lobes: &'a [LobeSet],
    energy: &'a [f64],
    /// Of each vertex: its neighbours and the plans to them.
    around: Vec<Vec<(u32, EdgePlan)>>,
}

impl<'a> Endings<'a> {
    /// `energy`: directional-hemispherical values at the vertices; `plans`: of the mesh's edges.
    pub(crate) fn new(
        mesh: &'a IncidenceMesh,
        lobes: &'a [LobeSet],
        energy: &'a [f64],
        plans: &[EdgePlan],
    ) -> Self {
        let mut around = vec![Vec::new(); lobes.len()];
        for (&[a, b], plan) in mesh.topology.edges().iter().zip(plans) {
            around[a as usize].push((b, plan.clone()));
            around[b as usize].push((a, plan.reversed()));
        }
        Self { mesh, lobes, energy, around }
    }

    /// Where the peaks end that are missing at one end of an edge of the mesh.
    pub(crate) fn on(&self, [a, b]: [u32; 2]) -> Cliff {
        Cliff { gone: self.share(a, b), new: 1.0 - self.share(b, a) }
    }

    /// Past the rim: the [`ending`](Self::ending) of each lobe of a vertex there. Empty inside.
    pub(crate) fn past_rim(&self) -> Vec<Vec<DVec2>> {
        let mut ends: Vec<Vec<DVec2>> = vec![Vec::new(); self.lobes.len()];
        for &v in self.mesh.topology.boundary().iter().flatten() {
            let set = &self.lobes[v as usize];
            let mut of_lobes = vec![DVec2::ZERO; set.lobes.len()];
            for peak in peaks(set) {
                let ending = self.ending(v, &peak);
                peak.iter().for_each(|&i| of_lobes[i as usize] = ending);
            }
            ends[v as usize] = of_lobes;
        }
        ends
    }

    /// The share of the way to a neighbour after which the lobes end that have no partner there.
    fn share(&self, from: u32, to: u32) -> f64 {
        let plan = self.around[from as usize].iter().find(|(k, _)| *k == to);
        let pairs = plan.iter().flat_map(|(_, plan)| &plan.pairs);
        let alone: Vec<u16> = pairs.filter(|p| p.to.is_none()).filter_map(|p| p.from).collect();
        let along = self.ending(from, &alone).dot(self.at(to) - self.at(from));
        (1.0 / along.max(1e-9)).clamp(NEAREST, 1.0 - NEAREST)
    }

    /// The peak that is made of these lobes of `vertex` ends at vertex + δ (in the disk of incident
    /// directions) where δ · this = 1.
    fn ending(&self, vertex: u32, lobes: &[u16]) -> DVec2 {
        let part = |plan: &EdgePlan, end: fn(&Pair) -> f64| -> f64 {
            plan.pairs.iter().filter(|p| p.from.is_some_and(|i| lobes.contains(&i))).map(end).sum()
        };
        // The peak's energy at the neighbours over that here.
        let around: Vec<(DVec2, f64)> = self.around[vertex as usize]
            .iter()
            .map(|(k, plan)| {
                let here = self.seen(vertex, part(plan, |p| p.start));
                let there = self.seen(*k, part(plan, |p| p.end));
                (self.at(*k) - self.at(vertex), there / here.max(1e-300))
            })
            .collect();
        let most = around.iter().map(|a| a.1).fold(1.0, f64::max);
        let here = margin(1.0 / most);
        // The way down: normal equations of the plane through the margins.
        let (mut xx, mut xy, mut yy, mut fall) = (1e-9, 0.0, 1e-9, DVec2::ZERO);
        for &(way, there) in &around {
            let distance = way.length().max(1e-9);
            let there = if there < 0.5 { -BEYOND * distance } else { margin(there / most) };
            let unit = way / distance;
            xx += unit.x * unit.x;
            xy += unit.x * unit.y;
            yy += unit.y * unit.y;
            fall += (here - there) / distance * unit;
        }
        let down = DVec2::new(yy * fall.x - xy * fall.y, xx * fall.y - xy * fall.x);
        down.normalize_or_zero() * (RATE / here.max(1e-6))
    }

    /// The energy of lobes of this mass; much of it may lie below the horizon.
    fn seen(&self, v: u32, mass: f64) -> f64 {
        self.energy[v as usize] * mass / self.lobes[v as usize].total().max(1e-300)
    }

    fn at(&self, v: u32) -> DVec2 {
        self.mesh.vertices[v as usize].wi.truncate()
    }
}

/// Lobes that overlap (the centre of one within three deviations of the other's), together.
pub(crate) fn peaks(set: &LobeSet) -> Vec<Vec<u16>> {
    let overlap = |a: &Lobe, b: &Lobe| {
        let narrow = if a.covariance.trace() < b.covariance.trace() { a } else { b };
        narrow.covariance.inverse().quadratic(a.mean - b.mean) < 9.0
    };
    let mut peaks: Vec<Vec<u16>> = Vec::new();
    for (i, lobe) in set.lobes.iter().enumerate() {
        let near = |peak: &Vec<u16>| peak.iter().any(|&j| overlap(lobe, &set.lobes[j as usize]));
        let (joined, apart): (Vec<_>, Vec<_>) = peaks.into_iter().partition(near);
        peaks = apart;
        peaks.push(joined.into_iter().flatten().chain([i as u16]).collect());
    }
    peaks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::Covariance;
    use crate::measurement::Symmetry;
    use bsdfkit::DVec3;
    use bsdfkit_sphere::direction::from_degrees;

    /// Transmittance of unpolarised light into index n.
    fn transmittance(cosine: f64, n: f64) -> f64 {
        let c = (1.0 - (1.0 - cosine * cosine) / (n * n)).sqrt();
        let (s, p) = ((cosine - n * c) / (cosine + n * c), (n * cosine - c) / (n * cosine + c));
        1.0 - 0.5 * (s * s + p * p)
    }

    /// What a plate of index n whose back is tilted by these degrees lets through: the closed form.
    fn facet(wi: DVec3, n: f64, tilt: f64) -> f64 {
        let inside = DVec3::new(
            -wi.x / n,
            -wi.y / n,
            -(1.0 - wi.truncate().length_squared() / (n * n)).sqrt(),
        );
        let (s, c) = tilt.to_radians().sin_cos();
        let cosine = inside.dot(DVec3::new(s, 0.0, -c));
        let rest = 1.0 - n * n * (1.0 - cosine * cosine);
        let out = if rest > 0.0 { transmittance(rest.sqrt(), n) } else { 0.0 };
        transmittance(wi.z, n) * out
    }

    fn scene(n: f64, tilt: f64) -> (IncidenceMesh, Vec<LobeSet>, Vec<f64>, Vec<EdgePlan>) {
        let mut wi = vec![DVec3::Z];
        for t in [15.0, 30.0, 45.0, 60.0] {
            wi.extend((0..12).map(|p| from_degrees(t, f64::from(p) * 30.0)));
        }
        let lobe = |mass, x| Lobe {
            mass,
            mean: DVec2::new(x, 0.0),
            covariance: Covariance::isotropic(0.001),
        };
        // A peak that stays, and the facet's.
        let set = |&w: &DVec3| {
            let both = [lobe(0.4, 0.0), lobe(0.45 * facet(w, n, tilt), 0.8)];
            LobeSet { floor: 0.0, lobes: both.into_iter().filter(|l| l.mass > 0.0).collect() }
        };
        let lobes: Vec<LobeSet> = wi.iter().map(set).collect();
        let mesh = IncidenceMesh::new(&wi, Symmetry::None).expect("mesh");
        let energy = lobes.iter().map(LobeSet::total).collect();
        let between =
            |&[a, b]: &[u32; 2]| EdgePlan::between(&lobes[a as usize], &lobes[b as usize], 0.1);
        let plans = mesh.topology.edges().iter().map(between).collect();
        (mesh, lobes, energy, plans)
    }

    /// Where on the segment the facet's light ends.
    fn truth(a: DVec2, b: DVec2, n: f64, tilt: f64) -> f64 {
        let there = |s: f64| {
            let p = a + s * (b - a);
            facet(p.extend((1.0 - p.length_squared()).max(0.0).sqrt()), n, tilt) > 0.0
        };
        (0..1000).map(|k| f64::from(k) * 1e-3).find(|&s| !there(s)).unwrap_or(1.0)
    }

    #[test]
    fn total_reflection_of_facets_is_found_on_the_edges() {
        let (mut off, mut middle, mut count) = (0.0, 0.0, 0.0);
        for n in [1.42, 1.5, 1.62] {
            for tilt in [9.0, 16.0, 23.0, 30.0] {
                let (mesh, lobes, energy, plans) = scene(n, tilt);
                let endings = Endings::new(&mesh, &lobes, &energy, &plans);
                for &[a, b] in mesh.topology.edges() {
                    let ends = |v: u32| lobes[v as usize].lobes.len() < 2;
                    if ends(a) == ends(b) {
                        continue;
                    }
                    let at = |v: u32| mesh.vertices[v as usize].wi.truncate();
                    let cliff = endings.on([a, b]);
                    let (from, to, found) =
                        if ends(b) { (a, b, cliff.gone) } else { (b, a, 1.0 - cliff.new) };
                    let place = truth(at(from), at(to), n, tilt);
                    off += (found - place).abs();
                    middle += (0.5 - place).abs();
                    count += 1.0;
                }
            }
        }
        assert!(count > 100.0 && off / count < 0.14, "{}", off / count);
        assert!(off < 0.6 * middle, "{} {}", off / count, middle / count);
    }

    #[test]
    fn past_the_rim_a_peak_ends_where_its_facet_reflects_it() {
        // At azimuth 0 the light ends at 66.9 degrees.
        let (n, tilt) = (1.5, 4.0);
        let (mesh, lobes, energy, plans) = scene(n, tilt);
        let ends = Endings::new(&mesh, &lobes, &energy, &plans).past_rim();
        let rim = mesh.vertices.iter().position(|v| v.wi.distance(from_degrees(60.0, 0.0)) < 1e-9);
        let rim = rim.expect("a vertex");
        assert!(ends[0].is_empty() && ends[rim][0].length() < 4.0);
        let at = mesh.vertices[rim].wi.truncate();
        let distance = truth(at, at / at.length(), n, tilt) * (1.0 - at.length());
        let found = 1.0 / ends[rim][1].x;
        assert!((found / distance - 1.0).abs() < 0.4, "{found} {distance}");
    }

    #[test]
    fn lobes_without_light_leave_no_holes_in_numbers() {
        let (mesh, mut lobes, mut energy, _) = scene(1.5, 20.0);
        for v in (0..lobes.len()).step_by(3) {
            lobes[v].lobes.iter_mut().for_each(|l| l.mass = 0.0);
            energy[v] = 0.0;
        }
        let between =
            |&[a, b]: &[u32; 2]| EdgePlan::between(&lobes[a as usize], &lobes[b as usize], 0.1);
        let plans: Vec<EdgePlan> = mesh.topology.edges().iter().map(between).collect();
        let endings = Endings::new(&mesh, &lobes, &energy, &plans);
        assert!(endings.past_rim().iter().flatten().all(|end| end.is_finite()));
        for &edge in mesh.topology.edges() {
            let Cliff { gone, new } = endings.on(edge);
            assert!((0.04..0.96).contains(&gone) && (0.04..0.96).contains(&new), "{gone} {new}");
        }
    }
}
