/* The tests on a host. */

#include "test.h"
#include <stdio.h>

void test_print(const char *text)
{
    (void)fputs(text, stdout);
}

int main(void)
{
    return test_run() == 0U ? 0 : 1;
}
