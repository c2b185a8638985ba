//! Identities of the admissible surface on random covariances.
