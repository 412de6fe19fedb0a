//! How much of the energy follows facets.

use bsdfkit::DVec3;

use crate::interpolant::component::planned::Planned;
use crate::interpolant::facet::refracted_lobe;
use crate::interpolant::motion::cell_movers::Moved;

impl Planned {
    /// The share of a vertex's energy that follows facets.
    pub(crate) fn following(&self, vertex: u32) -> f64 {
        self.of_followers(vertex).0 / self.hemispherical(vertex).max(1e-300)
    }

    /// The energy of a vertex's lobes that follow facets, and their mass above the horizon.
    fn of_followers(&self, vertex: u32) -> (f64, f64) {
        let set = &self.lobes[vertex as usize];
        let at = self.motion.frame.at(self.mesh.vertices[vertex as usize].wi);
        let mut following = 0.0;
        let families = self.families[vertex as usize].iter().flatten();
        let mut all = std::f64::consts::PI * set.floor
            + families.map(|l| l.lobe.mass * refracted_lobe::visible(&l.lobe, &at)).sum::<f64>();
        for (i, lobe) in set.lobes.iter().enumerate() {
            let visible = lobe.mass * refracted_lobe::visible(lobe, &at);
            all += visible;
            if self.facets.rules(vertex, i as u16) {
                following += visible;
            }
        }
        (self.hemispherical(vertex) * following / all.max(1e-300), following)
    }

    /// At `wi` (folded): the energy that follows facets.
    pub(crate) fn on_facets(&self, wi: DVec3) -> f64 {
        let (corners, lambda, _) = self.cell(self.mesh.locate(wi));
        let at = self.motion.frame.at(wi);
        let visible = |m: &Moved| m.lobe.mass * refracted_lobe::visible(&m.lobe, &at);
        let followers = self.facets.moved(&self.lobes, (corners, lambda), (wi, &at), None);
        let follow: f64 = followers.iter().map(visible).sum();
        // What the measured energy is of the lobes' own.
        let (mut seen, mut all) = (0.0, 0.0);
        for k in 0..3 {
            let (energy, mass) = self.of_followers(corners[k]);
            if mass > 0.0 {
                seen += lambda[k] * energy / mass;
                all += lambda[k];
            }
        }
        if all > 0.0 { follow * seen / all } else { 0.0 }
    }
}
