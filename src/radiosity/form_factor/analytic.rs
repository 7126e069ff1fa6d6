use super::View;

/// Form factors in closed form, times the visible share.
pub(super) struct Analytic<'a> {
    view: View<'a>,
    visibility_rays: u32,
}

impl<'a> Analytic<'a> {
    pub(super) fn new(view: View<'a>, visibility_rays: u32) -> Self {
        Self {
            view,
            visibility_rays,
        }
    }

    /// The form factor from element `i` to element `j`.
    pub(super) fn form_factor(&self, i: usize, j: usize) -> f64 {
        let _ = (&self.view, self.visibility_rays, i, j);
        todo!()
    }
}
