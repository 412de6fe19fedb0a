"""A virtual goniophotometer for micro-geometry: a beam onto one cell, escaping rays counted by direction.

f of a cell is its share of the light over its projected solid angle, pi / CELLS^2: an instrument with a square aperture of
about two degrees. The lamp fills a Gaussian of BEAM_DEGREES, so that light which goes straight through has a width.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ._cells import CELLS, blocks, direction, means

BEAM_DEGREES = 2.0
BATCH = 1 << 19
MOST_EVENTS = 256
#: Rays are wrapped to the other side of the cell this share of the period beyond it.
MARGIN = 0.125


def cell_of(x, y):
    """The number of the cell of direction cosines (drjit arrays)."""
    r = dr.minimum(dr.sqrt(x * x + y * y), 0.9999999)
    phi = dr.atan2(y, x)
    quarter = dr.floor(phi * (2 / dr.pi) + 0.5)
    across = r * (phi - quarter * (dr.pi / 2)) * (4 / dr.pi)
    q = mi.Int32(quarter) & 3
    a = dr.select(q == 0, r, dr.select(q == 1, -across, dr.select(q == 2, -r, across)))
    b = dr.select(q == 0, across, dr.select(q == 1, r, dr.select(q == 2, -across, -r)))
    index = lambda s: dr.clip(mi.Int32((s + 1) * (0.5 * CELLS)), 0, CELLS - 1)
    return mi.UInt32(index(a) * CELLS + index(b))


@dr.syntax
def trace(specimen, o, d, rng):
    """Follows rays until they leave above or below: their direction, weight, and whether they left."""
    px, py = specimen.period
    scene = specimen.scene
    context = mi.BSDFContext(mi.TransportMode.Importance)
    weight = mi.Float(1.0) + dr.zeros(mi.Float, dr.width(o))
    active = dr.full(mi.Bool, True, dr.width(o))
    left = dr.full(mi.Bool, False, dr.width(o))
    events = dr.zeros(mi.UInt32, dr.width(o))
    while active:
        ray = mi.Ray3f(o, d)
        si = scene.ray_intersect(ray, active)
        # where the ray leaves the patch: sideways, or for good
        ends = lambda d, period: dr.select(d > 0, (1.0 + MARGIN) * period, -MARGIN * period)
        far = lambda o, d, period: (ends(d, period) - o) / dr.select(dr.abs(d) < 1e-9, 1e-9, d)
        side = dr.minimum(dr.abs(far(o.x, d.x, px)), dr.abs(far(o.y, d.y, py)))
        out = dr.select(d.z > 0, specimen.top - o.z, o.z - specimen.bottom) / dr.maximum(dr.abs(d.z), 1e-9)
        hit = active & si.is_valid() & (si.t <= side)
        gone = active & ~hit & (out <= side)
        wrapped = active & ~hit & ~gone
        left |= gone
        bsdf = si.bsdf(ray)
        sample, w = bsdf.sample(context, si, rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32()), hit)
        bounced = si.spawn_ray(si.to_world(sample.wo))
        o = dr.select(hit, bounced.o, dr.select(wrapped, o + side * d, o))
        d = dr.select(hit, dr.normalize(bounced.d), d)
        weight = dr.select(hit, weight * w[0], weight)
        o.x = dr.select(hit | wrapped, o.x - px * dr.floor(o.x / px), o.x)
        o.y = dr.select(hit | wrapped, o.y - py * dr.floor(o.y / py), o.y)
        # roulette: one of four goes on, with four times the weight
        faint = hit & (weight < 0.05)
        survives = rng.next_float32() < 0.25
        weight = dr.select(faint, dr.select(survives, 4.0 * weight, 0.0), weight)
        events += 1
        active &= ~gone & (weight > 0) & (events < MOST_EVENTS)
    return d, weight, left


def escaped(specimen, wi, seed, beam_degrees, rays):
    """Direction, weight, and whether they left, of rays onto a cell from `wi`: one direction, or one a ray, all from one side.

    Light from below (z < 0) falls on the underside.
    """
    seed = dr.opaque(mi.UInt64, seed)
    rng = mi.PCG32(size=rays, initstate=seed, initseq=dr.arange(mi.UInt64, rays) + (seed << 24))
    columns = int(np.sqrt(rays))
    k = dr.arange(mi.UInt32, rays)
    px, py = specimen.period
    # stratified over the cell
    x = px * (mi.Float(k % columns) + rng.next_float32()) / columns
    y = py * (mi.Float(k // columns) + rng.next_float32()) / (rays / columns)
    # opaque: another direction or seed is no other program
    one = np.ndim(wi) == 1
    frame = mi.Frame3f(mi.Vector3f(*(dr.opaque(mi.Float, float(c)) if one else mi.Float(c) for c in np.transpose(wi))))
    spread = np.radians(beam_degrees)
    radius = spread * dr.sqrt(-2 * dr.log(1 - 0.9999 * rng.next_float32()))
    sin, cos = dr.sincos(2 * dr.pi * rng.next_float32())
    w = dr.normalize(frame.to_world(mi.Vector3f(radius * cos, radius * sin, 1.0)))
    above = np.reshape(wi, (-1, 3))[0, 2] > 0
    # what the lamp sends along the sample misses it
    w.z = dr.maximum(dr.abs(w.z), 0.01) * (1.0 if above else -1.0)
    start = specimen.top - 1e-3 if above else specimen.bottom + 1e-3
    return trace(specimen, mi.Point3f(x, y, start), -dr.normalize(w), rng)


def batch(specimen, wi, seed, beam_degrees=BEAM_DEGREES, rays=BATCH):
    """Light of one batch: (upward, downward) by cell, each ray's weight over their number; and what got lost."""
    d, weight, left = escaped(specimen, wi, seed, beam_degrees, rays)
    light = []
    for up in (True, False):
        bins = dr.zeros(mi.Float, CELLS * CELLS)
        dr.scatter_add(bins, weight, cell_of(d.x, d.y), left & ((d.z > 0) == up))
        light.append(np.array(bins, float) / rays)
    lost = float(np.array(dr.sum(dr.select(left, 0.0, weight)))[0]) / rays
    return light, lost


@dataclass
class Measured:
    """One side of one incidence: f of every cell, rays in each; of all that was asked the noise of blocks (L1), all energy."""

    values: np.ndarray
    rays: np.ndarray
    noise: float
    energy: float


def measure(specimen, theta, phi, seed, ups=(True, False), noise=0.03, least=4, most=8, **options):
    """Batches in pairs until two halves of them agree over all sides (`ups`: upward, downward light) that are asked for.

    Their L1 over both is the noise of the whole. One `Measured` a side.
    """
    halves, energy, done = [np.zeros((len(ups), CELLS * CELLS)) for _ in range(2)], 0.0, 0
    while True:
        for half in halves:
            light, _ = batch(specimen, direction(theta, phi), seed * 1000 + done, **options)
            half += [light[0 if up else 1] for up in ups]
            energy += sum(part.sum() for part in light)
            done += 1
        both = halves[0] + halves[1]
        rays = both * options.get("rays", BATCH)
        apart = 0.0
        for part, difference in zip(rays, halves[0] - halves[1]):
            number, _ = blocks(part)
            apart += (np.abs(means(number, difference)) * np.bincount(number)).sum()
        found = apart / max(both.sum(), 1e-12)
        if done >= least and (found <= noise or done >= most):
            values = both / done * CELLS**2 / np.pi
            return [Measured(v, r, found, energy / done) for v, r in zip(values, rays)]
