"""What a strain-energy law lacks on tests of a fabric."""
