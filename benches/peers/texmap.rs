//! texmap's side of the race.

use texmap_lab::bench_scenes::BenchScene;
pub(crate) use texmap_sample::Precision;

pub(crate) fn precisions(_scene: &BenchScene) -> &'static [Precision] {
    &[Precision::Fast]
}
pub(crate) fn name(_p: Precision) -> &'static str { "fast" }
pub(crate) struct Texmap;
impl Texmap {
    pub(crate) fn new(_: &[BenchScene], _: usize) -> Self { Self }
    pub(crate) fn frame(&mut self, _: &BenchScene, _: Precision) {}
    pub(crate) fn picture(&self, s: &BenchScene) -> Vec<u8> { let (w, h) = s.size(); vec![0; (w * h * if s.name.starts_with("depth") { 2 } else { 3 }) as usize] }
}
