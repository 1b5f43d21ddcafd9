//! Laws and regressions of the sampler.

mod blocks;
mod conformance;
mod cubes;
mod dependent;
mod encoded;
mod filters;
mod hostile;
mod joint;
mod lanes;
mod lengths;
mod levels;
mod light;
mod plane;
mod resampling;
mod shapes;
mod summed_area;
mod support;
mod volume_rays;
mod volumes;
mod wraps;
