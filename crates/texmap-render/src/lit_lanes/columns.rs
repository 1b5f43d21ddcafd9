//! The colours of one block from what the stages of its run have read.

use texmap_light::lanes::{
    PowerLanes, RayLanes, TermsLanes, V3, clamp_to_horizon, dot, reflect_across, share, splat, unit,
};
use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*};
use texmap_math::glam::DMat3;
use texmap_math::lanes::below;
use texmap_math::simd::X16;
use texmap_raster::{RunBlock, RunValues};

use super::banded::banded;
use super::side::{Side, Three, load};
use super::vectors::{NORMAL, POSITION, TANGENT, changes, column, three};
use super::{AMBIENT, EXPONENT, Lamp, LitLanes, REFLECTIVITY, Reads, Relief, SPECULAR};
use crate::canvas::{Colors, LANES};
use crate::plan::LightStage;
use crate::relief::Space;
use crate::shade::Run;

/// What the stages of a run read.
pub(super) struct Columns<'a> {
    pub(super) stage: &'a LitLanes<'a>,
    pub(super) run: &'a Run<'a>,
    /// Where the vectors stand.
    pub(super) values: &'a RunValues,
    pub(super) read: &'a Reads,
}

impl Columns<'_> {
    /// [`block`](Self::block) with all that any surface asks for. Out of line, so that the short form stays short.
    #[inline(never)]
    pub(super) fn any_block<S: Simd>(
        &self,
        s: S,
        i: usize,
        at: RunBlock,
        side: &Side,
        found: &Colors,
    ) -> [f32x16<S>; 4] {
        s.vectorize(
            #[inline(always)]
            || self.block::<S, true>(s, i, at, side, found),
        )
    }

    /// The colours of a block; `found` holds the base colours that the stages have found. What only surfaces ask for that read all their
    /// attributes is left out unless `ALL`: with it the others would be shaded by half slower.
    #[inline(always)]
    pub(super) fn block<S: Simd, const ALL: bool>(
        &self,
        s: S,
        i: usize,
        at: RunBlock,
        side: &Side,
        found: &Colors,
    ) -> [f32x16<S>; 4] {
        let (stage, one) = (self.stage, f32x16::splat(s, 1.0));
        let [mut diffuse, mut highlight] = match stage.surface.light {
            _ if !ALL => self.light::<S, ALL>(s, i, at, side),
            LightStage::PerPixel => self.light::<S, ALL>(s, i, at, side),
            LightStage::Terms { diffuse, highlight } => {
                let highlight = match highlight {
                    Some(first) => three(s, self.values, first, i),
                    None => [f32x16::splat(s, 0.0); 3],
                };
                [three(s, self.values, diffuse, i), highlight]
            }
            LightStage::Colors(first) => {
                let (_, alpha) = self.ground(s, i, found);
                let mut color = three(s, self.values, first, i);
                if let Some(emitted) = self.emitted(s, i) {
                    for k in 0..3 {
                        color[k] = below(color[k] + emitted[k], one);
                    }
                }
                let [r, g, b] = color;
                return [r * alpha, g * alpha, b * alpha, alpha];
            }
            LightStage::None => {
                let (mut color, alpha) = self.ground(s, i, found);
                if let Some(emitted) = self.emitted(s, i) {
                    for k in 0..3 {
                        color[k] += emitted[k];
                    }
                }
                let [r, g, b] = color;
                let [r, g, b] = [below(r, one), below(g, one), below(b, one)];
                return [r * alpha, g * alpha, b * alpha, alpha];
            }
        };
        if ALL && let Some(ramp) = &stage.surface.light_ramp {
            diffuse = load(s, &banded(ramp, at.mask, &store(diffuse)));
        }
        if ALL && let Some(emitted) = self.emitted(s, i) {
            for k in 0..3 {
                highlight[k] += emitted[k];
            }
        }
        let (mut base, alpha) = if ALL {
            self.ground(s, i, found)
        } else {
            (self.texels(s, i), one)
        };
        if ALL && !stage.paints.is_empty() {
            let [r, g, b, a] = self.painted(s, i, at, side);
            let keep = 1.0 - a;
            base = [r + keep * base[0], g + keep * base[1], b + keep * base[2]];
        }
        let mut out = [alpha; 4];
        for k in 0..3 {
            out[k] = below(base[k] * diffuse[k] + highlight[k], one);
            if ALL {
                out[k] *= alpha;
            }
        }
        out
    }

    /// The light that a block gives off itself.
    #[inline(always)]
    fn emitted<S: Simd>(&self, s: S, i: usize) -> Option<V3<S>> {
        let stage = self.stage.surface.emission.as_ref()?;
        let color = splat(X16(s), stage.color);
        if stage.map.is_none() {
            return Some(color);
        }
        let [r, g, b] = self.read.emission.straight(s, i);
        Some([r * color[0], g * color[1], b * color[2]])
    }

    /// Diffuse light and highlights of a block.
    #[inline(always)]
    fn light<S: Simd, const ALL: bool>(
        &self,
        s: S,
        i: usize,
        at: RunBlock,
        side: &Side,
    ) -> [V3<S>; 2] {
        let (stage, zero) = (self.stage, f32x16::splat(s, 0.0));
        let pixels = mask32x16::<S>::from_bitmask(s, u64::from(at.mask));
        let back = mask32x16::<S>::from_bitmask(s, u64::from(side.back));
        let point = match stage.position {
            Some(first) => three(s, self.values, if ALL { first } else { POSITION }, i),
            None => [zero; 3],
        };
        let (mut smooth, mut normal, mut toward_eye) = (point, point, point);
        // Without a light that asks for the normal nothing shows it.
        if stage.turned || self.read.slides.iter().any(|slide| slide.reaches(i)) {
            let first = if ALL { stage.normal } else { NORMAL };
            smooth = turned(back, three(s, self.values, first, i));
            if stage.sees_eye {
                for k in 0..3 {
                    toward_eye[k] = stage.eye[k] - point[k];
                }
                toward_eye = unit(X16(s), toward_eye);
            }
            normal = self.relieved::<S, ALL>(s, i, back, unit(X16(s), smooth));
            if stage.surface.material.horizon_clamp && !matches!(stage.relief, Relief::None) {
                normal = clamp_to_horizon(X16(s), normal, toward_eye);
            }
        }
        let mut sum = TermsLanes::dark(X16(s));
        // Ambient light of an ambient map: a colour of its own, which multiplies neither the base colour nor that of the highlight.
        let mut own = [zero; 3];
        let power = match stage.maps[EXPONENT] {
            Some(_) if ALL => {
                let [factor, ..] = self.read.maps[EXPONENT].straight(s, i);
                PowerLanes::Each(factor * stage.numbers.ns)
            }
            _ => PowerLanes::Same(stage.power),
        };
        let mut slide = self.read.slides.iter();
        for lamp in &stage.lights {
            let texel = match lamp.slide.as_ref().and_then(|_| slide.next()) {
                None => None,
                Some(texels) => match texels.lanes(s, i) {
                    None => continue,
                    some => some,
                },
            };
            let model = stage.surface.material.highlight;
            let given = share(
                X16(s),
                &stage.numbers,
                power,
                model,
                &lamp.light,
                point,
                normal,
                toward_eye,
            );
            let lit = given.lit & pixels;
            if !lit.any_true() {
                continue;
            }
            if ALL && lamp.is_ambient() && stage.maps[AMBIENT].is_some() {
                let texel = self.read.maps[AMBIENT].straight(s, i);
                for k in 0..3 {
                    own[k] += given.color[k] * given.diffuse * texel[k];
                }
                continue;
            }
            let received = self.received(s, lamp, texel, lit, point, side);
            sum.add(&given, lit, received);
        }
        let TermsLanes {
            mut diffuse,
            mut highlight,
        } = sum;
        if let Some((share, ..)) = stage.baked {
            let light = self.read.baked.straight(s, i);
            for k in 0..3 {
                diffuse[k] += light[k] * share;
            }
        }
        if ALL && stage.maps[SPECULAR].is_some() {
            let tint = self.read.maps[SPECULAR].straight(s, i);
            for k in 0..3 {
                highlight[k] *= tint[k];
            }
        }
        if ALL && stage.maps[AMBIENT].is_some() {
            for k in 0..3 {
                highlight[k] += own[k];
            }
        }
        if stage.has_mirrors() {
            let ray = self.mirrored::<S, ALL>(s, i, at, back, smooth, normal);
            if let Some((mirror, share)) = &stage.mirror {
                let share = match stage.maps[REFLECTIVITY] {
                    Some(_) if ALL => self.read.maps[REFLECTIVITY].straight(s, i)[0] * *share,
                    _ => f32x16::splat(s, *share),
                };
                let light = mirror.radiance(X16(s), &ray);
                for k in 0..3 {
                    highlight[k] += light[k] * share;
                }
            }
            if ALL && let Some(map) = &stage.specular {
                let light = map.radiance(X16(s), &ray);
                for k in 0..3 {
                    highlight[k] += light[k] * stage.numbers.ks;
                }
            }
        }
        [diffuse, highlight]
    }

    /// Unit normals as the relief leaves them.
    #[inline(always)]
    fn relieved<S: Simd, const ALL: bool>(
        &self,
        s: S,
        i: usize,
        back: mask32x16<S>,
        normal: V3<S>,
    ) -> V3<S> {
        let stage = self.stage;
        match &stage.relief {
            Relief::None => normal,
            Relief::Slopes(_) | Relief::Carved(_) if !ALL => normal,
            Relief::Normals(map, _, space, packed) => {
                let texel = if !ALL || *packed {
                    self.read.texels[1].lanes(s, i)
                } else {
                    self.read.normals.straight(s, i)
                };
                match space {
                    Space::Object(to_world) => {
                        let world = to_world_lanes(s, to_world, map.decode(X16(s), texel));
                        unit(X16(s), turned(back, world))
                    }
                    Space::Tangent(_) => {
                        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
                        let first = if ALL { stage.tangent } else { TANGENT };
                        let tangent = three(s, self.values, first, i);
                        let sign = column(s, &self.values.columns[first + 3].value, i);
                        let sign = back.select(-sign, sign);
                        let sign = sign.simd_lt(zero).select(-one, one);
                        map.turn(X16(s), normal, tangent, sign, texel)
                    }
                }
            }
            Relief::Slopes(_) => match stage.position {
                Some(first) => {
                    let moves = changes(s, self.values, first, i);
                    self.read.slopes.bump(s, i, normal, moves)
                }
                None => normal,
            },
            Relief::Carved(carved) => match stage.position {
                Some(first) => {
                    let point = three(s, self.values, first, i);
                    let moves = changes(s, self.values, first, i);
                    carved.normals(s, point, moves, normal)
                }
                None => normal,
            },
        }
    }

    /// What reaches the pixels of a light.
    #[inline(always)]
    fn received<S: Simd>(
        &self,
        s: S,
        lamp: &Lamp<'_>,
        texel: Option<V3<S>>,
        lit: mask32x16<S>,
        point: V3<S>,
        side: &Side,
    ) -> V3<S> {
        let one = f32x16::splat(s, 1.0);
        let plane = side.plane(s);
        let mut share = one;
        for shade in lamp.shadows {
            share *= shade.visibility(X16(s), lit, point, plane);
        }
        let (Some([r, g, b]), Some(cast)) = (texel, &lamp.slide) else {
            return [share; 3];
        };
        if let Some(shade) = cast.shade() {
            let zero = f32x16::splat(s, 0.0);
            let some = r.simd_gt(zero) | g.simd_gt(zero) | b.simd_gt(zero);
            let left = share * shade.visibility(X16(s), lit & some, point, plane);
            share = some.select(left, share);
        }
        [r * share, g * share, b * share]
    }

    /// The paint on a block, premultiplied.
    #[inline(always)]
    fn painted<S: Simd>(&self, s: S, i: usize, at: RunBlock, side: &Side) -> [f32x16<S>; 4] {
        let (stage, zero) = (self.stage, f32x16::splat(s, 0.0));
        let mut sum = [zero; 4];
        let Some(first) = stage.position else {
            return sum;
        };
        let (point, plane) = (three(s, self.values, first, i), side.plane(s));
        let of_lights = self.read.slides.len() - stage.paints.len();
        for (cast, texels) in stage.paints.iter().zip(&self.read.slides[of_lights..]) {
            let Some(texel) = texels.premultiplied(s, i) else {
                continue;
            };
            let mut toward = point;
            for k in 0..3 {
                toward[k] = cast.thrown.position[k] - point[k];
            }
            let on = dot(plane, toward).simd_gt(zero) & texel[3].simd_gt(zero);
            let on = on & mask32x16::from_bitmask(s, u64::from(at.mask));
            let share = match cast.shade() {
                Some(shade) => shade.visibility(X16(s), on, point, plane),
                None => f32x16::splat(s, 1.0),
            };
            let keep = 1.0 - texel[3] * share;
            for k in 0..4 {
                sum[k] = on.select(texel[k] * share + keep * sum[k], sum[k]);
            }
        }
        sum
    }

    #[inline(always)]
    fn mirrored<S: Simd, const ALL: bool>(
        &self,
        s: S,
        i: usize,
        at: RunBlock,
        back: mask32x16<S>,
        smooth: V3<S>,
        normal: V3<S>,
    ) -> RayLanes<X16<S>> {
        let rays = &self.stage.rays;
        let view = RayLanes {
            direction: rays.block(s, self.run.pixel(at, 0)),
            dx: splat(X16(s), rays.dx),
            dy: splat(X16(s), rays.dy),
        };
        let [normal_dx, normal_dy] = changes(
            s,
            self.values,
            if ALL { self.stage.normal } else { NORMAL },
            i,
        );
        let length = dot(smooth, smooth).sqrt();
        let normal = RayLanes {
            direction: normal,
            dx: turned(back, normal_dx),
            dy: turned(back, normal_dy),
        };
        reflect_across(X16(s), &view, &normal, length)
    }
}

#[inline(always)]
fn store<S: Simd>(v: V3<S>) -> Three {
    let mut out = [[0.0; LANES]; 3];
    for (out, c) in out.iter_mut().zip(&v) {
        c.store_slice(out);
    }
    out
}

/// A matrix times the vectors in all lanes, in f64 as for one.
#[inline(always)]
fn to_world_lanes<S: Simd>(s: S, to_world: &DMat3, v: V3<S>) -> V3<S> {
    let [(x0, x1), (y0, y1), (z0, z1)] = [v[0].widen(), v[1].widen(), v[2].widen()];
    let mut out = v;
    for (k, out) in out.iter_mut().enumerate() {
        let (a, b, c) = (to_world.x_axis[k], to_world.y_axis[k], to_world.z_axis[k]);
        *out = s.narrow_f64x8(x0 * a + y0 * b + z0 * c, x1 * a + y1 * b + z1 * c);
    }
    out
}

/// The opposite vector in some lanes.
#[inline(always)]
fn turned<S: Simd>(lanes: mask32x16<S>, v: V3<S>) -> V3<S> {
    [
        lanes.select(-v[0], v[0]),
        lanes.select(-v[1], v[1]),
        lanes.select(-v[2], v[2]),
    ]
}
