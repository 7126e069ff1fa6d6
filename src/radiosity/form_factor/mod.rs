//! Form factors: how much of what leaves one element arrives at another.
//!
//! `F_ij` is the share of the light leaving element *i* that reaches element *j*; by reciprocity
//! (`A_i F_ij = A_j F_ji`) it is also the weight with which the radiosity of *j* arrives at *i*.

mod hit_list;

pub(crate) use hit_list::{BLACK, GONE, HitList, RowTracer, RowsBefore, SKY, Traced, trace};
