//! How the columns depend on each other.

#[derive(Clone, Debug, PartialEq)]
pub struct CollinearityReport {
    pub columns: Vec<ColumnCollinearity>,
    /// Pearson correlation of the columns, in coefficient order; `None` beyond the size limit
    /// unless included.
    pub correlation: Option<Vec<Vec<f64>>>,
    /// Per term, the share of its variance that belongs to each eigenvalue (ascending).
    pub variance_proportions: Option<Vec<Vec<f64>>>,
    pub near_dependencies: Vec<NearDependency>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct ColumnCollinearity {
    pub term: String,
    /// 1/(1−R²), centred; `None` for the constant.
    pub vif: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct NearDependency {
    pub eigenvalue: f64,
    pub condition_index: Option<f64>,
    /// The eigenvector: how much of each unit-length column takes part.
    pub weights: Vec<f64>,
    pub terms: Vec<String>,
    /// cos of the angle between the two columns, where there are two terms.
    pub cosine: Option<f64>,
    /// −v_i/v_j, which Eq. 26 says the cosine tends to, where there are two terms.
    pub weight_ratio: Option<f64>,
    /// R² of the leading term on the others, where there are more than two.
    pub r_squared: Option<f64>,
    pub sentence: String,
}
