"""A Klems file as its text says it, read by nothing of ours."""

import math
import xml.etree.ElementTree as ElementTree

NAMESPACE = "{http://windows.lbl.gov}"


class Klems:
    """The basis and the blocks of a file; bins and directions as WINDOW names them."""

    def __init__(self, path):
        root = ElementTree.parse(path).getroot()
        rings = root.iter(f"{NAMESPACE}AngleBasisBlock")
        self.rings = [(float(r.find(f"{NAMESPACE}Theta").text), int(r.find(f"{NAMESPACE}nPhis").text)) for r in rings]
        bounds = root.iter(f"{NAMESPACE}ThetaBounds")
        self.bounds = [
            (float(b.find(f"{NAMESPACE}LowerTheta").text), float(b.find(f"{NAMESPACE}UpperTheta").text)) for b in bounds
        ]
        self.blocks = {}
        for data in root.iter(f"{NAMESPACE}WavelengthData"):
            band = data.find(f"{NAMESPACE}Wavelength").text
            for block in data.iter(f"{NAMESPACE}WavelengthDataBlock"):
                direction = block.find(f"{NAMESPACE}WavelengthDataDirection").text
                text = block.find(f"{NAMESPACE}ScatteringData").text.replace(",", " ").split()
                n = math.isqrt(len(text))
                values = list(map(float, text))
                self.blocks[band, direction] = [values[r * n : (r + 1) * n] for r in range(n)]

    @property
    def directions(self):
        return sum(n for _, n in self.rings)

    def solid_angles(self):
        """Projected solid angle of every bin."""
        angles = []
        for (lower, upper), (_, n) in zip(self.bounds, self.rings):
            ring = math.cos(math.radians(lower)) ** 2 - math.cos(math.radians(upper)) ** 2
            angles += [math.pi * ring / n] * n
        return angles

    def centres(self):
        """θ and φ of every bin, in degrees."""
        return [(theta, 360.0 * k / n) for theta, n in self.rings for k in range(n)]

    def hemispherical(self, band, direction):
        """Of each incident bin the share of light that is scattered."""
        matrix, angles = self.blocks[band, direction], self.solid_angles()
        return [sum(row[i] * omega for row, omega in zip(matrix, angles)) for i in range(len(angles))]

    def direct(self, band, direction):
        """Of each incident bin the share that goes straight on, or back as from a mirror."""
        matrix, angles = self.blocks[band, direction], self.solid_angles()
        return [matrix[i][i] * omega for i, omega in enumerate(angles)]

    def bin(self, theta, phi):
        """The bin of a direction in degrees, and how far its nearest border is in degrees along θ and φ."""
        first = 0
        for (lower, upper), (_, n) in zip(self.bounds, self.rings):
            if theta < upper:
                width = 360.0 / n
                k = round(phi / width) % n
                along = abs((phi - k * width + 180.0) % 360.0 - 180.0)
                margin = min(theta - lower if lower > 0.0 else 90.0, upper - theta)
                return first + k, min(margin, width / 2.0 - along if n > 1 else 90.0)
            first += n
        raise ValueError(f"no bin for theta {theta}")
