"""What signals and growth rates say, as numbers alone: exponentials, verdict, crossings."""
