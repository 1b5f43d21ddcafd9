//! The scene files, word for word.

/// File name and text of every scene.
pub(crate) const SCENES: [(&str, &str); 10] = [
    ("purple_cow.scene", PURPLE_COW),
    ("checker_floor.scene", CHECKER_FLOOR),
    ("brick_wall_tiled.scene", BRICK_WALL),
    ("fence.scene", FENCE),
    ("teapot.scene", TEAPOT),
    ("label.scene", LABEL),
    ("frame_ouv.scene", FRAME_OUV),
    ("shapes.scene", SHAPES),
    ("teapot_slides.scene", TEAPOT_SLIDES),
    ("painted_cow.scene", PAINTED_COW),
];

const PURPLE_COW: &str = "\
# Purple Cow Doom, the room of MIT 6.837 (Fall 2001), lecture 18, slide 18. Up is +Z.
# The lecture looks straight ahead: eye 0 0 6, look 0 1 6. Here the viewer has stepped back and looks down a
# little, so that floor, ceiling and cow are in the picture.
eye 3.5 -13 6.2
look -0.6 10 4.2
up 0 0 1
fov 60
# The slide's la 1 1 1 and ld 1 1 1 0.5 0.5 -1 go with its surf, whose ka and kd are 0.5. Only the cow is lit here,
# and the ka and kd of an OBJ are 1: the lights are halved instead.
la 0.5 0.5 0.5
ld 0.5 0.5 0.5 0.5 0.5 -1
surf 0.8 0.2 0.9 0.5 0.5 0.0 1.0

# The slide's first eight vertices are lost; its faces begin with vertex 8. A floor and a ceiling fit the gap.
texture ../textures/carpet.gif
v -20 -20 0
v 20 -20 0
v 20 20 0
v -20 20 0
tf 0 0 10 1 10 10 2 10 0 3 0 0
texture ../textures/ceilingtile.gif
v -20 -20 10
v 20 -20 10
v 20 20 10
v -20 20 10
tf 4 0 0 5 16 0 6 16 16 7 0 16

# The slide's walls and its pillar, as listed. One picture holds a wall in each quarter of its height.
texture ../textures/walls.gif
v -20 20 0
v 20 20 0
v 20 20 10
v -20 20 10
tf 8 0 0.25 9 1 0.25 10 1 0 11 0 0

v 15 -20 0
v 15 20 0
v 15 20 10
v 15 -20 10
tf 12 1 0.5 13 0 0.5 14 0 0.25 15 1 0.25

v 5 10 0
v 10 10 0
v 5 15 0
v 10 15 0
v 5 10 10
v 10 10 10
v 5 15 10
v 10 15 10
tf 16 0.9 0.25 17 1 0.25 21 1 0 20 0.9 0
tf 16 0.9 0.25 18 1 0.25 22 1 0 20 0.9 0
tf 17 0.9 0.25 19 1 0.25 23 1 0 21 0.9 0
tf 18 0.9 0.25 19 1 0.25 23 1 0 22 0.9 0

# The room's other two walls, for a walk through it; not on the slide.
v -20 -20 0
v -20 -20 10
v 15 -20 10
tf 24 0 0.75 8 1 0.75 11 1 0.5 25 0 0.5
tf 12 0 1 24 0.875 1 25 0.875 0.75 26 0 0.75

# The cow.
push
translate -1.4 6.5 0
rotate -38 0 0 1
rotate 90 1 0 0
scale 3.6
obj ../models/cow.obj
pop
";

const CHECKER_FLOOR: &str = "\
# A checkered floor that runs to the horizon: the classic test of perspective and of minification.
eye 0 1.6 6
look 0.6 1.1 0
up 0 1 0
fov 60
background 0.53 0.71 0.92
texture ../textures/checker.png
filter trilinear
v -200 0 20
v 200 0 20
v 200 0 -400
v -200 0 -400
tf 0 0 105 1 100 105 2 100 0 3 0 0
";

const BRICK_WALL: &str = "\
# One brick picture tiled over a wall that is seen at a slant, and over its pillar.
eye -4.5 1.7 4
look 1.2 1.6 0
up 0 1 0
fov 62
background 0.60 0.74 0.90
texture ../textures/brick.png
wrap repeat
v -6 0 0
v 14 0 0
v 14 4 0
v -6 4 0
tf 0 0 2 1 10 2 2 10 0 3 0 0
v 1 0 0
v 1 0 0.8
v 2 0 0.8
v 2 0 0
v 1 4 0
v 1 4 0.8
v 2 4 0.8
v 2 4 0
tf 4 3.5 2 5 3.9 2 9 3.9 0 8 3.5 0
tf 5 3.9 2 6 4.4 2 10 4.4 0 9 3.9 0
tf 6 4.4 2 7 4.8 2 11 4.8 0 10 4.4 0
texture ../textures/ceilingtile.gif
v -6 0 8
v 14 0 8
tf 12 0 8 13 20 8 1 20 0 0 0 0
";

const FENCE: &str = "\
# A picket fence and leaves cut out of rectangles by alpha; the lawn and the leaves behind show through.
eye -1.8 1.5 5
look 0.4 0.8 0
up 0 1 0
fov 55
background 0.66 0.82 0.96
surf 0.36 0.62 0.26 1 0 0 1
la 1 1 1
v -30 0 12
v 30 0 12
v 30 0 -40
v -30 0 -40
f 0 1 2 3

texture ../textures/brick.png
v -7 0 -6
v 7 0 -6
v 7 3 -6
v -7 3 -6
tf 4 0 1.5 5 7 1.5 6 7 0 7 0 0

# Leaves: a PNG with graded alpha, a GIF with one transparent colour.
texture ../textures/leaf.png
v -0.9 0.1 -1.4
v 0.3 0.1 -1.4
v 0.3 1.3 -1.6
v -0.9 1.3 -1.6
tf 8 0 1 9 1 1 10 1 0 11 0 0
texture ../textures/leaf.gif
v 1.1 0.2 -1.8
v 2.1 0.2 -1.4
v 2.1 1.2 -1.4
v 1.1 1.2 -1.8
tf 12 0 1 13 1 1 14 1 0 15 0 0

texture ../textures/fence.png
wrap repeat clamp-to-edge
v -6 0 0
v 6 0 0
v 6 1.2 0
v -6 1.2 0
tf 16 0 1 17 10 1 18 10 0 19 0 0
";

const TEAPOT: &str = "\
# The Utah teapot with the labelled grid, on a checkered table.
eye 3.8 4.2 7.4
look 0.25 1.35 0
up 0 1 0
fov 54
background 0.16 0.18 0.22
la 0.35 0.35 0.35
ld 0.8 0.8 0.75 -0.5 -1 -0.6
texture ../textures/checker.png
v -6 0 6
v 6 0 6
v 6 0 -6
v -6 0 -6
tf 0 0 1.5 1 1.5 1.5 2 1.5 0 3 0 0
obj ../models/teapot.obj
";

const LABEL: &str = "\
# A label texture: the face is all in the picture, the head below it has only a nose. Beside it a cube, whose
# six faces show the labelled grid.
eye 1.0 0.3 4.6
look 0.78 -0.05 0
up 0 1 0
fov 50
background 0.22 0.26 0.30
la 0.45 0.45 0.45
ld 0.7 0.7 0.7 -0.6 -0.6 -1
push
rotate 14 0 1 0
obj ../models/head.obj
pop
push
translate 1.75 -0.35 -0.2
rotate 32 0 1 0
rotate 18 1 0 0
scale 1.05
obj ../models/cube.obj
pop
";

const FRAME_OUV: &str = "\
# Polygons textured by a frame (O, U, V) instead of vertex coordinates (Brackeen 2003, chapter 8): in the plane,
# turned by 30 degrees and skewed.
eye 0 1.2 5.2
look 0 0.9 0
up 0 1 0
fov 72
background 0.14 0.15 0.18
texture ../textures/uv_grid.png
v -3.1 0 0.6
v -1.2 0 0
v -1.2 2 0
v -3.1 2 0.6
frame -3.1 2 0.6 1.9 0 -0.6 0 -2 0
ff 0 1 2 3

v -0.95 0.3 0
v 0 -0.1 0
v 0.95 0.3 0
v 0.95 1.5 0
v 0 2.1 0
v -0.95 1.5 0
frame -0.6 1.9 0 1.3 0.75 0 0.75 -1.3 0
ff 4 5 6 7 8 9

v 1.2 0 0
v 3.1 0 0.6
v 3.1 2 0.6
v 1.2 2 0
frame 1.2 2 0 0.95 0 0.3 0.475 -1 0.15
ff 10 11 12 13
";

const SHAPES: &str = "\
# Surfaces that move: bricks that stand out of their wall, a bent arm, ground from a picture of heights, and leaves on cards.
eye -1.5 2.6 6.5
look 0.2 1.1 0
fov 50
background 0.72 0.82 0.92
la 0.35 0.35 0.38
ld 0.75 0.72 0.65 0.8 -0.75 -0.7
shadow 2048
filter trilinear
shade modulate pixel

# The wall: bricks are brighter than mortar. Its outline and its shadows are those of the bricks.
texture ../textures/brick.png
displace ../textures/brick.png 0.25 middle 0.4 pixels 3
v -3 0 0
v 1 0 0
v 1 2.6 0
v -3 2.6 0
tf 0 0 2   1 3 2   2 3 0   3 0 0
displace none

# The arm: a cylinder whose upper half leans over.
push
bone 2.2 0 0.6   2.2 1 0.6
bone 2.2 1 0.6   2.2 2 0.6 parent 0 turn 50 0 0 1
skin smooth 0.9
texture ../textures/checker.png
translate 2.2 1 0.6
scale 0.7 2 0.7
obj ../models/cylinder.obj
pop

# Ground, and leaves over it.
texture ../textures/carpet.gif
terrain ../textures/hills.png 0 -0.7 1.5 9 1 7 step 2
texture ../textures/leaf.png
billboard -0.9 0.6 2.6 0.8 0.8
billboard 0.1 0.5 2.4 0.6 0.6 axis 0 1 0
";

const TEAPOT_SLIDES: &str = "\
# The teapot under two slide projectors, as MIT 6.837 (Fall 2001) lecture 18, slide 26, shows it.
eye 0.4 3.6 7.6
look 0.1 1.2 0
up 0 1 0
fov 48
background 0.10 0.11 0.14
la 0.12 0.12 0.12
projector ../textures/uv_grid.png light -7 4.5 6   0 1.2 0   0 1 0   26 color 1 0.95 0.85 shadow 1024
projector ../textures/brick.png light 7 3.5 5   0 1.2 0   0 1 0   28 color 0.85 0.9 1 shadow 1024
surf 0.85 0.83 0.80 1 1 0 30
v -6 0 6
v 6 0 6
v 6 0 -6
v -6 0 -6
f 0 1 2 3
obj ../models/teapot_white.obj
";

const PAINTED_COW: &str = "\
# A cow painted by a picture, seen from beside the projector: what that does not see keeps its own colour
# (MIT 6.837, Fall 2001, lecture 18, slide 26).
eye 2.6 1.7 3.3
look 0.1 0.9 0
up 0 1 0
fov 40
background 0.62 0.72 0.82
la 0.45 0.45 0.45
ld 0.6 0.6 0.55 -0.4 -1 -0.7
projector ../textures/uv_grid.png paint -1.2 1.4 4.2   0.1 0.95 0   0 1 0   42 shadow 1024
obj ../models/cow.obj
";
