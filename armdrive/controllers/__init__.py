"""The driver's end of each dialect: neutral requests to the dialect's bytes, answers back."""
