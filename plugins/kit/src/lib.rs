//! What several Rumbo plugins share: ray casting, distance fields, grid search.
