//! The use cases of shapes: curves and surfaces kept with an iteration.

use std::sync::Arc;

use uuid::Uuid;

use super::{
    page::{Page, PageRequest},
    repository::{RepositoryError, Stored},
    service::{Jobs, Keyed},
    shape::{Shape, ShapeDraft, ShapeSummary},
};

impl Jobs {
    /// Keeps a shape with an iteration, beside those it has.
    pub async fn add_shape(
        &self,
        job: Uuid,
        number: u32,
        draft: ShapeDraft,
        keyed: Option<Keyed<Shape>>,
    ) -> Result<(Arc<Shape>, Stored), RepositoryError> {
        let now = self.clock.now();
        let shape = Arc::new(Shape { id: self.ids.fresh(now), created_at: now, draft });
        let receipt = keyed.map(|keyed| keyed.receipt(shape.clone()));
        let stored = self.repository.insert_shape(job, number, shape.clone(), receipt).await?;
        Ok((shape, stored))
    }

    pub async fn shape(&self, job: Uuid, number: u32, id: Uuid) -> Result<Shape, RepositoryError> {
        self.repository.shape(job, number, id).await
    }

    /// Oldest first.
    pub async fn shapes(
        &self,
        job: Uuid,
        number: u32,
        page: PageRequest,
    ) -> Result<Page<ShapeSummary>, RepositoryError> {
        self.repository.shapes(job, number, page).await
    }
}
