"""The surfaces of glTF as `holo` understands them, as plugins of Mitsuba 3. Import after `mi.set_variant`.

Four plugins: `gltf_lambert`, `gltf_varnish`, `gltf_metal`, `gltf_glass`. Formulas are in README.md. All of them take the side of the
*geometric* normal from which a ray arrives as the outside of reflection, turn the shading normal to that side and let nothing pass that
a shading normal would send through the triangle.

Sources: GGX and refraction, Walter et al. 2007; height-correlated masking, Heitz 2014; sampling of visible normals, Dupuy and Benyoub
2023; coupling of diffuse and specular, Kelemen and Szirmay-Kalos 2001.
"""
import drjit as dr
import mitsuba as mi
import numpy as np

# Nodes of the table of the albedo, uniform in the cosine.
NODES = 256
# Midpoints in azimuth and in the other number of `visible_normal`, per node. Four times as many change the table by less than 5e-5.
QUADRATURE = (48, 1536)


def ggx(cosine, alpha):
    """Density of microfacet normals at a cosine to the mean normal."""
    d = 1 + cosine * cosine * (alpha * alpha - 1)
    return alpha * alpha * dr.inv_pi / (d * d)


def slope(cosine, alpha):
    """Smith's Lambda for a cosine above 0."""
    squared = cosine * cosine
    return 0.5 * (dr.sqrt(1 + alpha * alpha * (1 - squared) / squared) - 1)


def visible_normal(wi, alpha, numbers):
    """A microfacet normal as seen from `wi`: density D(h) G1(wi) max(0, wi.h) / wi.z."""
    v = dr.normalize(mi.Vector3f(alpha * wi.x, alpha * wi.y, wi.z))
    z = (1 - numbers.y) * (1 + v.z) - v.z
    sine = dr.safe_sqrt(1 - z * z)
    s, c = dr.sincos(2 * dr.pi * numbers.x)
    h = mi.Vector3f(sine * c, sine * s, z) + v
    return dr.normalize(mi.Vector3f(alpha * h.x, alpha * h.y, dr.maximum(h.z, 1e-7)))


def fresnel(cosine, eta):
    """Reflectance of a dielectric and the cosine beyond; `eta`: index beyond over index before."""
    squared = 1 - (1 - cosine * cosine) / (eta * eta)
    beyond = dr.safe_sqrt(squared)
    parallel = (eta * cosine - beyond) / (eta * cosine + beyond)
    perpendicular = (cosine - eta * beyond) / (cosine + eta * beyond)
    reflected = 0.5 * (parallel * parallel + perpendicular * perpendicular)
    return dr.select(squared > 0, reflected, 1), beyond


def fifth(cosine):
    """(1 - cosine)^5."""
    x = dr.maximum(1 - cosine, 0)
    return x * x * x * x * x


def albedo_table(alpha, f0, f90):
    """Directional albedo of the GGX lobe with Schlick's Fresnel at NODES cosines from 0 to 1, and its mean."""
    # The tail of the distribution, where light goes below the surface, has a share of alpha^2 in v: it needs many strata.
    u, v = np.meshgrid((np.arange(QUADRATURE[0]) + 0.5) / QUADRATURE[0], (np.arange(QUADRATURE[1]) + 0.5) / QUADRATURE[1])
    cosines = np.maximum(np.arange(NODES) / (NODES - 1), 1e-5)
    lam = lambda c: 0.5 * (np.sqrt(1 + alpha**2 * (1 - c * c) / (c * c)) - 1)
    table = np.zeros(NODES)
    for k, cosine in enumerate(cosines):
        sine = np.sqrt(1 - cosine**2)
        vx, vz = np.array([alpha * sine, cosine]) / np.hypot(alpha * sine, cosine)
        z = (1 - v) * (1 + vz) - vz
        r = np.sqrt(np.maximum(1 - z * z, 0))
        # Symmetric in the azimuth: half a turn will do.
        hx, hy, hz = alpha * (r * np.cos(np.pi * u) + vx), alpha * r * np.sin(np.pi * u), z + vz
        length = np.sqrt(hx * hx + hy * hy + hz * hz)
        hx, hz = hx / length, hz / length
        towards = np.maximum(sine * hx + cosine * hz, 0)
        out = 2 * towards * hz - cosine
        valid = out > 0
        out = np.where(valid, out, 1)
        f = f0 + (f90 - f0) * (1 - np.minimum(towards, 1)) ** 5
        table[k] = np.mean(np.where(valid, f * (1 + lam(cosine)) / (1 + lam(cosine) + lam(out)), 0))
    mean = np.trapezoid(2 * table * cosines, cosines) if hasattr(np, "trapezoid") else np.trapz(2 * table * cosines, cosines)
    return table, mean


class Surface(mi.BSDF):
    """What the plugins have in common: the frame on the side from which light is looked at."""

    def __init__(self, props, *kinds):
        mi.BSDF.__init__(self, props)
        self.base = props.get_texture("base")
        flags = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [kind | flags for kind in kinds]
        self.m_flags = flags
        for kind in kinds:
            self.m_flags = self.m_flags | kind

    def traverse(self, callback):
        callback.put("base", self.base, mi.ParamFlags.Differentiable)

    def side(self, si):
        """1 where the ray arrives at the front of the triangle, else -1."""
        return dr.select(dr.dot(si.n, si.to_world(si.wi)) < 0, mi.Float(-1), mi.Float(1))

    def turned(self, w, side):
        return mi.Vector3f(w.x, w.y, w.z * side)

    def beyond(self, si, wo, side):
        """Geometric cosine of `wo` on the side of arrival: below 0 beyond the triangle."""
        return dr.dot(si.n, si.to_world(wo)) * side

    def sample(self, ctx, si, number, numbers, active):
        side = self.side(si)
        local, lobe, value = self.draw(si, self.turned(si.wi, side), side, number, numbers, active)
        bs = dr.zeros(mi.BSDFSample3f)
        bs.wo = self.turned(local, side)
        bs.eta = 1.0
        bs.sampled_component = dr.select(lobe, mi.UInt32(1 if len(self.m_components) > 1 else 0), mi.UInt32(0))
        if value is None:
            f, density = self.evaluate(si, self.turned(si.wi, side), local, side, active)
            bs.pdf = dr.select(active, density, 0)
            bs.sampled_type = mi.UInt32(int(self.m_components[0]) & ~int(mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide))
            value = dr.select(bs.pdf > 0, f / dr.select(bs.pdf > 0, bs.pdf, 1), 0)
        else:
            bs.pdf = 1.0
            kinds = [mi.UInt32(int(c) & ~int(mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide)) for c in self.m_components]
            bs.sampled_type = dr.select(lobe, kinds[1], kinds[0])
        # The same side by both normals, or neither.
        agrees = (self.beyond(si, bs.wo, side) > 0) == (local.z > 0)
        good = active & agrees & (bs.pdf > 0)
        bs.pdf = dr.select(good, bs.pdf, 0)
        return bs, dr.select(good, value, 0)

    def eval_pdf(self, ctx, si, wo, active):
        side = self.side(si)
        local = self.turned(wo, side)
        f, density = self.evaluate(si, self.turned(si.wi, side), local, side, active)
        good = active & ((self.beyond(si, wo, side) > 0) == (local.z > 0))
        return dr.select(good, f, 0), dr.select(good, density, 0)

    def eval(self, ctx, si, wo, active):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active):
        return self.eval_pdf(ctx, si, wo, active)[1]


class Lambert(Surface):
    """base / pi."""

    def __init__(self, props):
        super().__init__(props, mi.BSDFFlags.DiffuseReflection)

    def draw(self, si, wi, side, number, numbers, active):
        return mi.warp.square_to_cosine_hemisphere(numbers), mi.Bool(False), None

    def evaluate(self, si, wi, wo, side, active):
        density = dr.maximum(wo.z, 0) * dr.inv_pi
        return self.base.eval(si, active) * density, density


class Metal(Surface):
    """GGX with Schlick's Fresnel between the base color and white."""

    def __init__(self, props):
        super().__init__(props, mi.BSDFFlags.GlossyReflection)
        self.alpha = float(props["roughness"]) ** 2

    def draw(self, si, wi, side, number, numbers, active):
        h = visible_normal(wi, self.alpha, numbers)
        return 2 * dr.dot(wi, h) * h - wi, mi.Bool(False), None

    def lobe(self, wi, wo):
        """D G2 / (4 wi.z), density, and the cosine to the microfacet."""
        valid = (wi.z > 0) & (wo.z > 0)
        ci, co = dr.select(valid, wi.z, 1), dr.select(valid, wo.z, 1)
        h = dr.normalize(wi + wo)
        d = ggx(h.z, self.alpha) / (4 * ci)
        li, lo = slope(ci, self.alpha), slope(co, self.alpha)
        return dr.select(valid, d / (1 + li + lo), 0), dr.select(valid, d / (1 + li), 0), dr.dot(wi, h)

    def evaluate(self, si, wi, wo, side, active):
        value, density, towards = self.lobe(wi, wo)
        base = self.base.eval(si, active)
        return (base + (1 - base) * fifth(towards)) * value, density


class Varnish(Metal):
    """A Lambertian surface under the GGX lobe of a dielectric: Schlick's Fresnel between F0 and the specular factor."""

    def __init__(self, props):
        Surface.__init__(self, props, mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DiffuseReflection)
        self.alpha = float(props["roughness"]) ** 2
        ior, specular = float(props.get("ior", 1.5)), float(props.get("specular", 1.0))
        self.f0, self.f90 = ((ior - 1) / (ior + 1)) ** 2 * specular, specular
        table, mean = albedo_table(self.alpha, self.f0, self.f90)
        self.table, self.mean = mi.Float(table.astype(np.float32)), float(mean)
        dr.eval(self.table)

    def albedo(self, cosine):
        place = dr.clip(cosine, 0, 1) * (NODES - 1)
        k = dr.minimum(mi.UInt32(place), NODES - 2)
        low, high = dr.gather(mi.Float, self.table, k), dr.gather(mi.Float, self.table, k + 1)
        return low + (high - low) * (place - mi.Float(k))

    def share(self, si, wi, active):
        """Probability of drawing from the specular lobe."""
        albedo = self.albedo(wi.z)
        base = dr.mean(self.base.eval(si, active))
        return dr.clip(albedo / (albedo + (1 - albedo) * base), 0.1, 0.9)

    def draw(self, si, wi, side, number, numbers, active):
        h = visible_normal(wi, self.alpha, numbers)
        specular = number < self.share(si, wi, active)
        diffuse = mi.warp.square_to_cosine_hemisphere(numbers)
        return dr.select(specular, 2 * dr.dot(wi, h) * h - wi, diffuse), mi.Bool(False), None

    def evaluate(self, si, wi, wo, side, active):
        value, density, towards = self.lobe(wi, wo)
        cosine = dr.maximum(wo.z, 0) * dr.inv_pi
        diffuse = (1 - self.albedo(wi.z)) * (1 - self.albedo(wo.z)) / (1 - self.mean) * cosine
        specular = (self.f0 + (self.f90 - self.f0) * fifth(towards)) * value
        share = self.share(si, wi, active)
        valid = wi.z > 0
        f = self.base.eval(si, active) * diffuse + specular
        return dr.select(valid, f, 0), dr.select(valid, share * density + (1 - share) * cosine, 0)


class Glass(Surface):
    """A dielectric boundary, smooth or rough, of a body that absorbs, or (`thin`) a smooth pane that bends no ray.

    What absorption leaves of the way through the body is charged where the way ends: every way inside ends on this surface.
    """

    def __init__(self, props):
        roughness = float(props.get("roughness", 0.0))
        self.thin = bool(props.get("thin", False))
        self.alpha = roughness * roughness
        self.ior = float(props.get("ior", 1.5))
        assert not (self.thin and roughness > 0), "rough panes are not modelled here"
        if roughness > 0:
            super().__init__(props, mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.GlossyTransmission)
        else:
            super().__init__(props, mi.BSDFFlags.DeltaReflection, mi.BSDFFlags.DeltaTransmission)
        self.absorption = mi.Color3f(*[float(props.get(f"absorption_{c}", 0.0)) for c in "rgb"])

    def left(self, si, side):
        """What absorption left of the light on the arriving ray."""
        # Mitsuba started that ray a little off the surface it left, here taken to have been as slanting as this one.
        ahead = mi.math.RayEpsilon * (1 + dr.max(dr.abs(si.p))) / dr.maximum(dr.abs(dr.dot(si.n, si.to_world(si.wi))), 0.1)
        return dr.select(side < 0, dr.exp(-self.absorption * dr.minimum(si.t + ahead, 1e6)), mi.Color3f(1))

    def index(self, side):
        """Index beyond over index on the side of arrival."""
        return mi.Float(1) if self.thin else dr.select(side > 0, mi.Float(self.ior), mi.Float(1 / self.ior))

    def draw(self, si, wi, side, number, numbers, active):
        if self.alpha > 0:
            h, eta = visible_normal(wi, self.alpha, numbers), self.index(side)
            cosine = dr.dot(wi, h)
            reflectance, beyond = fresnel(cosine, eta)
            reflects = number < reflectance
            wo = dr.select(reflects, 2 * cosine * h - wi, (cosine / eta - beyond) * h - wi / eta)
            # What a slanting microfacet reflects downward or refracts upward is lost, as in single scattering.
            return dr.select((wo.z > 0) == reflects, wo, mi.Vector3f(0)), mi.Bool(False), None
        tint = self.base.eval(si, active)
        if self.thin:
            reflectance, _ = fresnel(wi.z, mi.Float(self.ior))
            through, value = -wi, tint
        else:
            eta = self.index(side)
            reflectance, beyond = fresnel(wi.z, eta)
            through, value = mi.Vector3f(-wi.x / eta, -wi.y / eta, -beyond), tint / (eta * eta)
        reflects = number < reflectance
        value = dr.select(reflects, mi.Color3f(1), value)
        if not self.thin:
            value = value * self.left(si, side)
        valid = wi.z > 0
        return dr.select(reflects, mi.Vector3f(-wi.x, -wi.y, wi.z), through), ~reflects, dr.select(valid, value, 0)

    def evaluate(self, si, wi, wo, side, active):
        if self.alpha == 0:
            return mi.Color3f(0), mi.Float(0)
        valid = (wi.z > 0) & (wo.z != 0)
        ci, co = dr.select(valid, wi.z, 1), dr.select(valid, dr.abs(wo.z), 1)
        eta, reflects = self.index(side), wo.z > 0
        h = dr.normalize(wi + wo * dr.select(reflects, 1, eta))
        h = mi.Vector3f(h * dr.select(h.z < 0, mi.Float(-1), mi.Float(1)))
        hi, ho = dr.dot(wi, h), dr.dot(wo, h)
        valid &= (hi > 0) & ((ho > 0) == reflects)
        reflectance, _ = fresnel(dr.maximum(hi, 1e-6), eta)
        d = ggx(h.z, self.alpha) / ci
        li, lo = slope(ci, self.alpha), slope(co, self.alpha)
        crossing = hi + eta * ho
        # Radiance thins out by eta^2 where it spreads: the index is missing from the value and stands in the density.
        through = hi * dr.abs(ho) / dr.maximum(crossing * crossing, 1e-20)
        tint = self.base.eval(si, active)
        value = dr.select(reflects, mi.Color3f(reflectance / 4), tint * ((1 - reflectance) * through))
        density = dr.select(reflects, reflectance / 4, (1 - reflectance) * through * eta * eta)
        value = value * (d / (1 + li + lo)) * self.left(si, side)
        return dr.select(valid, value, 0), dr.select(valid, density * d / (1 + li), 0)


for name, plugin in [("lambert", Lambert), ("metal", Metal), ("varnish", Varnish), ("glass", Glass)]:
    mi.register_bsdf(f"gltf_{name}", lambda props, plugin=plugin: plugin(props))
