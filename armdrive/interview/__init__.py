"""The interview that writes an arm file: questions and answers as data, without any I/O."""
