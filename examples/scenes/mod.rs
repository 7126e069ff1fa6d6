//! The sample scenes, each made from nothing but this code: the same bytes on every run.

mod cornell_box;
mod courtyard;
mod furnace;
mod glb;
mod images;
mod relief;
mod shapes;

/// The file name and the bytes of each scene.
pub(super) fn all() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("cornell_box.glb", cornell_box::make()),
        ("courtyard.glb", courtyard::make()),
        ("furnace.glb", furnace::make()),
        ("relief.glb", relief::make()),
    ]
}

/// The file name and the bytes of each height map.
pub(super) fn maps() -> Vec<(&'static str, Vec<u8>)> {
    vec![("bricks.png", images::bricks())]
}
