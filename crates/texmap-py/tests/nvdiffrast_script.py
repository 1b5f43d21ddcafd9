"""A script as a user of nvdiffrast writes it: a textured model by the four calls, on the device that there is. A test changes its
import of nvdiffrast and nothing else."""

import sys

import numpy as np
import torch
import trimesh
from PIL import Image

import nvdiffrast.torch as dr

model, texture, picture = sys.argv[1:4]
device = "cuda" if torch.cuda.is_available() else "cpu"

mesh = trimesh.load(model, force="mesh", process=False)
vertices = mesh.vertices - mesh.bounds.mean(axis=0)
vertices = torch.tensor(vertices / np.abs(vertices).max(), dtype=torch.float32, device=device)
faces = torch.tensor(mesh.faces, dtype=torch.int32, device=device)
uvs = torch.tensor(mesh.visual.uv, dtype=torch.float32, device=device)
texels = np.asarray(Image.open(texture).convert("RGB"), np.float32)[::-1] / 255  # OpenGL: the first row is at v = 0
texels = torch.tensor(texels.copy(), device=device)[None]

# The eye at z = 6, the planes at 4 and 8; clip space as in OpenGL.
near, far, eye, zoom = 4.0, 8.0, 6.0, 5.0
projection = torch.tensor(
    [
        [zoom, 0, 0, 0],
        [0, zoom, 0, 0],
        [0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)],
        [0, 0, -1, 0],
    ],
    device=device,
)
view = torch.eye(4, device=device)
view[2, 3] = -eye
homogeneous = torch.cat([vertices, torch.ones_like(vertices[:, :1])], dim=1)
clip = (homogeneous @ (projection @ view).T)[None].contiguous()

context = dr.RasterizeCudaContext(device=device)
with torch.no_grad():
    rast, rast_db = dr.rasterize(context, clip, faces, resolution=[360, 360])
    coordinates, slopes = dr.interpolate(uvs[None], rast, faces, rast_db=rast_db, diff_attrs="all")
    color = dr.texture(texels, coordinates, slopes, filter_mode="linear-mipmap-linear", max_mip_level=5)
    color = torch.where(rast[..., 3:] > 0, color, torch.ones_like(color))
    color = dr.antialias(color, rast, clip, faces)

image = (color[0].clamp(0, 1) * 255 + 0.5).to(torch.uint8).cpu().numpy()[::-1]
Image.fromarray(np.ascontiguousarray(image)).save(picture)
