short_way = True  # False, before languages are loaded: the memory of their short ways is wanted for something else
