"""Left-to-right Gaussian HMMs of all symbols: scoring, fitting, and segmentation of takes."""
