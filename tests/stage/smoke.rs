use crate::support::scene::*;
use limpid::Config;
use limpid::frame::Options;
use limpid::pipeline::Pipeline;

#[test]
fn smoke() {
    let scene = Scene::of(&[
        Block::new([3.0, -3.0, 0.0], [3.2, 3.0, 2.5]),
        Block::new([2.0, 0.5, 0.0], [2.3, 0.8, 0.4]),
    ]);
    let first = scene.frame(0, small_camera(), pose(0.0, 0.0, 0.0, 0.6, 0.2));
    let mut pipeline =
        Pipeline::open(&Config::default(), &first, &Options { layers: true, ..Options::default() }).unwrap();
    let mut last = None;
    for i in 0..12 {
        let f = scene.frame(i, small_camera(), pose(0.0, 0.0, 0.0, 0.6, 0.2));
        pipeline.submit(&f).unwrap();
        last = pipeline.receive().unwrap();
        println!("{:?}", last.as_ref().unwrap().counters);
    }
    let out = last.unwrap();
    println!("{}", pipeline.executor().plan().table());
    println!("{:?}", pipeline.executor().allocation_bytes());
    for row in (90..150).rev() {
        let line: String = (110..200)
            .map(|x| match out.costmap[row * 240 + x] {
                0 => '.',
                255 => ' ',
                254 => '#',
                253 => '+',
                _ => '-',
            })
            .collect();
        println!("{line}");
    }
}
