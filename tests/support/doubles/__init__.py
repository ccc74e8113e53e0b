"""Cheap FMUs that stand in for the product's, and small systems whose motion is known exactly."""
