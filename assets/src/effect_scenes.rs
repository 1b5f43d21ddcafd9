//! One scene for each lighting effect that the other scenes lack, word for word.

/// File name and text of each.
pub(crate) const SCENES: [(&str, &str); 7] = [
    ("shadows.scene", SHADOWS),
    ("mirrors.scene", MIRRORS),
    ("reliefs.scene", RELIEFS),
    ("baked_light.scene", BAKED_LIGHT),
    ("solids.scene", SOLIDS),
    ("cloud.scene", CLOUD),
    ("signs.scene", SIGNS),
];

const SHADOWS: &str = "\
# Shadows of a sun, a lamp and a spot light, on the ground and on a wall; the fence lets light through its gaps.
eye 3.2 2.6 5.6
look 0.2 0.6 -0.2
fov 50
background 0.60 0.74 0.90
la 0.25 0.25 0.28
ld 0.5 0.48 0.42 -0.8 -1.2 -0.7
shadow 1024 taps 3
lp 0.25 0.2 0.15 -1.4 1.6 1.6
shadow 512 taps 1
ls 0.4 0.4 0.5 2.6 3.4 2.2 -2.4 -3.2 -2.6 34 46
shadow 1024 taps 5
surf 0.86 0.84 0.80 1 1 0.2 20
v -6 0 6
v 6 0 6
v 6 0 -3
v -6 0 -3
v 6 4 -3
v -6 4 -3
f 0 1 2 3
v -6 0 -3
v 6 0 -3
f 6 7 4 5
shade modulate pixel
texture ../textures/fence.png
wrap repeat clamp-to-edge
v -2.6 0 1.4
v -0.2 0 2.2
v -0.2 1 2.2
v -2.6 1 1.4
tf 8 0 1 9 4 1 10 4 0 11 0 0
texture none
surf 0.78 0.42 0.30 1 1 0.4 30
push
translate 1.0 0.5 0.6
obj ../models/ball_plain.obj
pop
push
translate -0.9 0.75 -1.2
rotate 30 0 1 0
scale 1 1.5 1
obj ../models/house.obj
pop
";

const MIRRORS: &str = "\
# A sky seen by direction and mirrored: by a ball, by a teapot whose pixels read the mean of what they mirror, and by lacquer under
# area lights, whose highlights come from a specular map.
eye 0.6 2.4 6.4
look 0.2 0.7 0
fov 52
sky ../textures/sky.png lat-long
la 0.5 0.5 0.5
ld 0.35 0.34 0.3 -0.5 -1 -0.4
surf 0.42 0.40 0.38 1 1 0 20
v -4 0 3
v 4 0 3
v 4 0 -4
v -4 0 -4
env ../textures/sky.png lat-long 0.25 mips
f 0 1 2 3
env ../textures/sky.png lat-long 0.7
push
translate -1.7 1 0
scale 2
obj ../models/ball_plain.obj
pop
env ../textures/sky.png lat-long 0.5 mips
push
translate 1.9 0 -0.4
rotate 20 0 1 0
scale 0.55
obj ../models/teapot_white.obj
pop
env none
specmap ../textures/lamps.png lat-long 40
surf 0.35 0.08 0.10 1 1 0.8 40
push
translate 0 0.6 1.9
scale 1.2
obj ../models/ball_plain.obj
pop
specmap none
";

const RELIEFS: &str = "\
# Surfaces whose light is turned by bumps: heights, slopes, normals as colours, waves carved by a formula, words; and a plate whose
# highlight comes from maps.
eye 0.2 2.9 5.6
look 0 0.75 0
fov 54
background 0.20 0.22 0.26
la 0.22 0.22 0.24
ld 0.7 0.68 0.62 -0.9 -0.8 -0.6
lp 0.35 0.35 0.4 2.4 2.2 3
lp 0.4 0.38 0.34 -0.15 2.3 -0.8
surf 0.72 0.66 0.58 1 1 0.3 24
shade modulate pixel
texture ../textures/brick.png
bump ../textures/brick_heights.png 0.03
v -4 0 3
v 4 0 3
v 4 0 -2
v -4 0 -2
tf 0 0 4 1 6 4 2 6 0 3 0 0
bump none
texture none
texture ../textures/face.png
normalmap ../textures/normals.png
v -3.4 0.1 -1.6
v -1.4 0.1 -2
v -1.4 2.1 -2
v -3.4 2.1 -1.6
tf 4 0 1 5 1 1 6 1 0 7 0 0
offsetmap ../textures/offsets.png 1.2
texture ../textures/uv_grid.png
v 1.4 0.1 -2
v 3.4 0.1 -1.6
v 3.4 2.1 -1.6
v 1.4 2.1 -2
tf 8 0 1 9 1 1 10 1 0 11 0 0
offsetmap none
texture ../textures/hills.png
emboss \"TEXMAP\" -0.02
v -1.2 0.6 -1.2
v 1.2 0.6 -1.2
v 1.2 1.4 -1.4
v -1.2 1.4 -1.4
tf 12 0 1 13 1 1 14 1 0 15 0 0
emboss none
texture none
carve waves 0.05 -1.4 0.5 1.2 1 0.25 1 around 10
push
translate -1.4 0.6 1.2
scale 0.9 1.2 0.9
obj ../models/cylinder.obj
pop
carve marble 0.06 1.3 0.5 1.3 0.4 0.4 0.4 octaves 3
push
translate 1.3 0.5 1.3
obj ../models/ball_plain.obj
pop
carve none
push
translate 0 0.02 2
scale 0.7
obj ../models/plate.obj
pop
";

const BAKED_LIGHT: &str = "\
# A cube under baked light, with colours of its own between; another one under the same lamp, live.
eye 1.2 1.6 3.4
look 0.1 0 0
fov 44
background 0.10 0.11 0.13
la 0.12 0.12 0.12
lp 0.9 0.88 0.8 2.2 2.6 1.6
lightmap ../textures/baked.png 1.2
lightmapuv ../models/cube_unfolded.obj
push
translate -0.75 0 0
rotate 24 0 1 0
obj ../models/cube.obj
pop
lightmap none
lightmapuv none
push
translate 0.85 0 -0.2
rotate -18 0 1 0
obj ../models/cube.obj
pop
";

const SOLIDS: &str = "\
# Carved out of space: marble, wood, noise through a ramp, and voxels.
eye 0.4 2.2 5
look 0 0.4 0
fov 48
background 0.30 0.33 0.38
la 0.4 0.4 0.4
ld 0.6 0.6 0.58 -0.6 -1 -0.8
solid wood 0 -0.4 0 0.35 0.35 2 fold 0.3
surf 1 1 1 1 1 0 5
v -4 -0.3 3
v 4 -0.3 3
v 4 -0.3 -5
v -4 -0.3 -5
f 0 1 2 3
solid marble -1.5 0.4 0 0.4 0.4 0.4 octaves 4
push
translate -1.5 0.45 0
scale 1.4
obj ../models/ball_plain.obj
pop
ramp ../textures/heat.png
solid noise 0 0.5 0 0.5 0.5 0.5 octaves 3
push
translate 0.2 0.35 0.4
rotate 25 0 1 0
obj ../models/cube_plain.obj
pop
solid ../textures/cloud.npy 1.7 0.35 0 1.2 1.2 1.2
push
translate 1.7 0.45 0
scale 1.1 1.4 1.1
obj ../models/cone.obj
pop
ramp none
solid none
";

const CLOUD: &str = "\
# Matter between the eye and the things: a white cloud before a wall, and a hot one by a ramp around a ball.
eye 0 1.2 5
look 0 0.7 0
fov 50
background 0.46 0.60 0.78
la 0.5 0.5 0.5
ld 0.5 0.5 0.5 -0.4 -1 -0.8
texture ../textures/brick.png
v -4 0 -2
v 4 0 -2
v 4 3 -2
v -4 3 -2
tf 0 0 3 1 6 3 2 6 0 3 0 0
texture none
surf 0.5 0.55 0.42 1 1 0 5
v -5 0 4
v 5 0 4
v 5 0 -2
v -5 0 -2
f 4 5 6 7
push
translate 1.2 0.6 0
obj ../models/ball_plain.obj
pop
wrap clamp-to-edge
volume ../textures/cloud.npy -1.1 1 0.2 2 1.7 2 3
ramp ../textures/flames.png
volume ../textures/cloud.npy 1.2 0.8 0.2 1.7 1.6 1.7 4 step 0.02
ramp none
";

const SIGNS: &str = "\
# Letters on a wall before a stretched picture of a sky, a label on a cube, a picture through a ramp of heat, a ball that shines in parts,
# and a teapot in three tones.
eye 0.5 1.6 5.4
look 0.1 0.8 0
fov 50
sky ../textures/sky.png
la 0.3 0.3 0.3
ld 0.7 0.7 0.68 -0.5 -0.9 -0.7
texture ../textures/brick.png
v -3 0 -1.4
v 1 0 -1.4
v 1 2.2 -1.4
v -3 2.2 -1.4
tf 0 0 2 1 4 2 2 4 0 3 0 0
surf 0.95 0.93 0.86 1 1 0 5
text \"TEXMAP\" -2.6 1.1 -1.36 0.5 0 0 0 0.8 0
surf 0.1 0.1 0.14 1 1 0 5
text \"far away\" -2.6 0.4 -1.36 0.14 0 0 0 0.2 0
texture ../textures/hills.png
ramp ../textures/heat.png
v 1.3 0 -1.2
v 3.2 0 -0.6
v 3.2 1.8 -0.6
v 1.3 1.8 -1.2
tf 4 0 1 5 1 1 6 1 0 7 0 0
ramp none
texture none
decal ../textures/label.png 0.2 0.2 0.6 0.6
push
translate -1.3 0.5 0.9
rotate 24 0 1 0
obj ../models/cube.obj
pop
decal none
surf 0.2 0.2 0.22 1 1 0.3 30
emission 1 0.72 0.3 ../textures/checker.png
push
translate -0.2 0.3 1.6
scale 0.6
obj ../models/ball_plain.obj
pop
emission none
cel ../textures/tones.png
surf 0.30 0.55 0.75 1 1 0.3 20
push
translate 1 0 0.9
scale 0.42
obj ../models/teapot_white.obj
pop
cel none
";
