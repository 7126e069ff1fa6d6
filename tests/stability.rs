//! What radiosity programs fail at, a test each.
//!
//! | what fails | test |
//! |---|---|
//! | surfaces at one place | [`coincident`]; `walls_modelled_twice` in `light` |
//! | a lamp in the plane of its ceiling | [`coincident::coplanar_lamp`] |
//! | slivers, triangles and objects of nothing | [`degenerate`]; `broken_scenes` in `bad_input` |
//! | numbers that are none, indices out of range | `bad_input` |
//! | quads that are not flat | [`degenerate::quads_that_are_not_flat`] |
//! | reflectance near 1, of 1 and beyond | [`enclosures`]; `furnace` in `truth`, `bright_closed_rooms_take_few_sweeps` in `radiosity::solve` |
//! | open scenes, light that escapes | [`enclosures::open_plates`], [`enclosures::open_furnace`] |
//! | one side and two | [`enclosures::sides_of_a_sheet`]; `sides` and `rooms_inside_out` in `light` |
//! | the unit of length | [`precision::unit_of_length`]; `scale` in `bad_input` |
//! | far from the origin | [`precision::rounded_far_from_the_origin`]; `far_from_the_origin` in `bad_input` |
//! | rays that meet the surface they start from, or tunnel | [`precision`] |
//! | cracks between triangles | `closed_surfaces_are_watertight` in `radiosity::bvh` |
//! | surfaces inside others | [`leaks::floor_under_a_block`], [`leaks::block_across_the_cells_of_the_floor`] |
//! | light behind walls | [`leaks::light_leak_through_thin_wall`]; `no_light_leaks_through_a_wall` in `light` |
//! | mirrored and stretched instances | [`instances`]; `mirrored_node_keeps_its_front` in `gltf` |
//! | tiny lamps | [`emitters::tiny_lamp_left_to_chance`]; `a_tiny_emitter_is_a_point_light` in `light` |
//! | bright and dim in one scene | [`emitters::dim_light_beside_bright_light`] |
//! | threads | [`determinism::threads`]; `any_number_of_threads_gives_the_same_bits` in `behaviour` |
//! | elements that touch or nearly do, half-hidden ones | with the form factors' methods, in `radiosity::form_factor` |
//! | aliasing, turns and weights of the hemicube; cancellation in closed forms | there too |
//! | sums of rows above 1 | there too: `largest_row_sum` and `scaled_rows` of the report |
//! | solvers that stop early, diverge, or bound their error wrongly | in `radiosity::solve` |

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

#[path = "stability/coincident.rs"]
mod coincident;
#[path = "stability/degenerate.rs"]
mod degenerate;
#[path = "stability/determinism.rs"]
mod determinism;
#[path = "stability/emitters.rs"]
mod emitters;
#[path = "stability/enclosures.rs"]
mod enclosures;
#[path = "stability/instances.rs"]
#[cfg(feature = "gltf")]
mod instances;
#[path = "stability/leaks.rs"]
mod leaks;
#[path = "stability/precision.rs"]
mod precision;
#[path = "stability/solved.rs"]
mod solved;
