"""The analogue power of the tool, exact to the word, and a laser's rows of dots: `spindle.pwm` asks for them."""
