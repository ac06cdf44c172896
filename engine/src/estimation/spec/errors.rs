//! What is known of the errors of the heights.

/// How scan lines run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// Along u at each v: the columns of a grid.
    U,
    /// Along v at each u: the rows of a grid.
    V,
    /// Along the abscissae of a curve, or in the order posted.
    Order,
}

impl Along {
    /// As the interface writes it.
    pub fn name(self) -> &'static str {
        match self {
            Along::U => "u",
            Along::V => "v",
            Along::Order => "order",
        }
    }
}
