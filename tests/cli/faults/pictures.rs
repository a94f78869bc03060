//! Silhouettes and templates: the order of frames, their pixels, their gait cycles.
