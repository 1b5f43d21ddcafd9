//! `texmap info`.
