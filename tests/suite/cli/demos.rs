//! `texmap demo`.
