//! What a pixel shows over the views: how its color changes with their places.

/// The sums of a pixel over the views in which it is visible.
#[derive(Clone, Copy, Default)]
pub(super) struct Sums {
    /// The gradients of the image by row and by column, channel by channel.
    pub(super) gradients: [[f32; 2]; 3],
    /// The sums of color differences times the places of their views, down and right.
    pub(super) pulls: [[f32; 2]; 3],
    /// The sums of squared places, down and right, and of their product.
    pub(super) spread: [f32; 3],
    /// The variance of the differences; 0: no view.
    pub(super) variance: f32,
    /// The information that the noise of the gradients alone has.
    pub(super) noise: f32,
}

impl Sums {
    /// The sums of the linear fit of `pulls` to `gradients`: of squares, and of products.
    pub(super) fn fit(&self, gradients: &[[f32; 2]; 3], pulls: &[[f32; 2]; 3]) -> (f32, f32) {
        let [down, right, both] = self.spread;
        let (mut squares, mut products) = (0.0, 0.0);
        for ([y, x], [pull_y, pull_x]) in gradients.iter().zip(pulls) {
            squares += down * y * y + right * x * x + 2.0 * both * y * x;
            products += y * pull_y + x * pull_x;
        }
        (squares, products)
    }
}
